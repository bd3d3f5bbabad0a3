"""tools/eval/quality: networks and what a user would pick instead, against path-traced references."""

import argparse
import json
import os
import platform
import shlex
import signal
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from pathlib import Path

from evaluation import BadInput
from lightformer_train import files
from lightformer_train.arguments import SEEDS, Parser, whole

from . import figures, methods, sequence, tables, timing
from .figures import Truth
from .methods import Method
from .renderer import PROGRAM, ROOT, Renderer, Shot, digest, scene_digest, variation

PARTS = {
    "time": "what a frame costs; the other parts need it for equal time",
    "frames": "figures of every method on the test frames",
    "oidn": "the time that path tracing and denoising need for the error of the first network",
    "temporal": "what changes from frame to frame",
    "unseen": "networks on scenes with something that no training showed",
}
RESULT = "quality.json"
positive, seed = whole(1), whole(0, SEEDS - 1)  # numbers on command lines
AT_ONCE = 2  # methods being judged: figures of one are computed, by one thread, while another's picture is made


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line."""
    parser = Parser(
        prog="tools/eval/quality",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Judges networks, the rasterizer, path tracing and Open Image Denoise on test frames,\n"
        "each beside two independent path-traced references. Pictures are kept in DIR/pictures and made only once; a\n"
        "study that was interrupted goes on. Writes DIR/quality.json, which holds one study, and prints tables.",
        epilog="parts:\n" + "\n".join(f"  {name:10} {what}" for name, what in PARTS.items()),
    )
    add = parser.add_argument
    add("weights", nargs="*", type=_named, metavar="[NAME=]WEIGHTS", help="networks; the first is ours")
    add("--scene", type=Path, default=ROOT / "content/chess/chess.glb", metavar="FILE", help="default: Chess")
    add("--frames", type=positive, default=20, metavar="N", help="test frames (default 20)")
    add("--seeds", type=seed, default=900000, metavar="FIRST", help="of their variations (default 900000)")
    add("--size", type=positive, default=512, metavar="N", help="pixels a side (default 512)")
    add("--spp", type=positive, default=512, metavar="N", help="of each of the two references (default 512)")
    add("--paths", type=positive, nargs="*", default=[], metavar="N", help="also judge path tracing with so many spp")
    add(
        "--unseen",
        type=Path,
        nargs="*",
        default=sorted(ROOT.glob("content/unseen/*.glb")),
        metavar="FILE",
        help="scenes with something that no training showed (default: content/unseen)",
    )
    add("--unseen-frames", type=positive, default=5, metavar="N", help="test frames of each (default 5)")
    add("--unseen-spp", type=positive, default=128, metavar="N", help="of their references (default 128)")
    add("--most-paths", type=positive, default=256, metavar="N", help="spp of the part oidn's search (default 256)")
    add("--moving", type=Path, default=ROOT / "content/chess/flight.glb", metavar="FILE", help="scene of the sequence")
    add("--moving-frames", type=positive, default=30, metavar="N", help="of the sequence (default 30)")
    add("--moving-size", type=positive, default=256, metavar="N", help="pixels a side (default 256)")
    add("--moving-spp", type=positive, default=256, metavar="N", help="of its references (default 256)")
    add("--only-networks", action="store_true", help="judge nothing else on the test frames")
    add("--parts", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART", help="not all parts; those done stay")
    add("--program", type=Path, default=PROGRAM, metavar="FILE", help="lightformer")
    add("--out", type=Path, default=ROOT / "out/quality", metavar="DIR", help="default out/quality")
    add("--force", action="store_true", help="overwrite the tables of another study in --out; its pictures stay")
    add("--pictures", type=Path, metavar="DIR", help="where pictures are kept (default: pictures in --out)")
    values = parser.parse_args(arguments)
    names = [name for name, _ in values.weights]
    if len(set(names)) < len(names):
        parser.error("two networks have the same name: give them others, as NAME=WEIGHTS")
    return values


def _named(text: str) -> tuple[str, Path]:
    name, given, path = text.rpartition("=")
    return (name if given else Path(path).name.partition(".")[0]), Path(path)


def read_json(path: Path) -> dict:
    """Of a study."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{path}: {os.strerror(error.errno)}") from error
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path}: {error}") from error
    if not isinstance(found, dict):
        raise BadInput(f"{path}: not the result of a study")
    return found


def settings_of(options: argparse.Namespace, networks: dict[str, str]) -> dict:
    """What all parts of a study have in common. `networks`: the hash of each."""
    return {
        "scene": options.scene.stem,
        "scene_hash": scene_digest(options.scene),
        "frames": options.frames,
        "seeds": options.seeds,
        "size": options.size,
        "spp": options.spp,
        "networks": networks,
    }


def earlier_result(options: argparse.Namespace, settings: dict) -> dict:
    """What an earlier run with these settings found; nothing, if there was none or it may be overwritten. BadInput if
    that would be a loss."""
    path = options.out / RESULT
    if not path.exists():
        return {}
    try:
        earlier = _read_result(path)
    except BadInput:
        if options.force:
            return {}
        raise
    found = earlier["settings"]
    if found == settings:
        return earlier
    if options.force or (_are_more(found, settings) and PARTS.keys() & earlier.keys() <= set(options.parts)):
        return {}
    raise BadInput(
        f"{path}: is of another study ({_difference(found, settings)}); choose another --out, or overwrite it (--force)"
    )


def _read_result(path: Path) -> dict:
    earlier = read_json(path)
    if not isinstance(earlier.get("settings"), dict) or not isinstance(earlier.get("made", {}), dict):
        raise BadInput(f"{path}: not the result of a study; --force overwrites it")
    return earlier


def _are_more(earlier: dict, settings: dict) -> bool:
    """Whether these differ in networks alone, the earlier ones being among them."""
    networks = earlier.get("networks")
    same = {key: value for key, value in settings.items() if key != "networks"}
    return (
        isinstance(networks, dict)
        and {key: value for key, value in earlier.items() if key != "networks"} == same
        and networks.items() <= settings["networks"].items()
    )


def _difference(earlier: dict, settings: dict) -> str:
    """Of the first setting that differs."""
    key = next((key for key in settings if key != "networks" and earlier.get(key) != settings[key]), None)
    return f"{key} {earlier.get(key)}, not {settings[key]}" if key else "other networks, or more parts than are asked for"


class Study:
    """One run of the command; `command` is what repeats it, `notes` what else the result is to tell."""

    def __init__(self, options: argparse.Namespace, command: str, notes: dict | None = None) -> None:
        self.options, self.command, self.notes = options, command, notes or {}
        self.renderer = Renderer(options.pictures or options.out / "pictures", options.program)
        self.networks = [methods.network(name, path) for name, path in options.weights]
        self.result = self._begin()

    def _begin(self) -> dict:
        """What an earlier run with these settings found, or nothing yet."""
        settings = settings_of(self.options, {method.name: digest(method.weights) for method in self.networks})
        earlier = earlier_result(self.options, settings)
        parts = {name: earlier[name] for name in PARTS if name in earlier}
        made = {name: tables.made(earlier, name) for name in parts}
        return {"settings": settings, "made": made} | self.notes | parts

    def run(self) -> None:
        """Every part that was asked for; the result is written after each."""
        parts: dict[str, Callable[[], dict | None]] = {
            "time": self._time,
            "frames": self._frames,
            "oidn": self._oidn,
            "temporal": self._temporal,
            "unseen": self._unseen,
        }
        for name, part in parts.items():
            if name not in self.options.parts:
                continue
            found = part()
            if found is None:
                continue
            self.result[name] = found
            self.result["made"][name] = {
                "command": self.command,
                "machine": machine(),
                "program": self.renderer.version,
            }
            self._write()
            print(f"\n{tables.text(tables.PARTS[name](self.result))}", flush=True)
        if self.result["made"]:
            print(f"\n{tables.text(tables.of_making(self.result))}", flush=True)

    def _write(self) -> None:
        files.write_atomically(self.options.out / RESULT, json.dumps(self.result, indent=1).encode())

    # ---- parts

    def _time(self) -> dict:
        o = self.options
        return timing.measure(self.renderer, o.scene, o.size, [*self.networks, methods.raster()])

    def _frames(self) -> dict:
        o = self.options
        others = [
            methods.raster(),
            *self._paths(),
            *(methods.denoised(1, quality) for quality in methods.OIDN_QUALITIES),
        ]
        judged = self.networks if o.only_networks else [*self.networks, *others]
        return self._judge(o.scene, o.frames, o.size, o.spp, judged)

    def _paths(self) -> list[Method]:
        """Path tracing at equal time, and with as many samples as were asked for."""
        wanted = {1, *self.options.paths}
        if self.networks and "time" in self.result:
            ours = timing.of_frame(self.result["time"], self.networks[0].name)
            wanted.add(timing.paths_that_fit(self.result["time"], ours))
        return [methods.paths(spp) for spp in sorted(wanted)]

    def _judge(self, scene: Path, frames: int, size: int, spp: int, judged: list[Method]) -> dict:
        """Every method on every test frame of a scene."""
        rows: dict[str, list[dict]] = {method.name: [] for method in judged}
        shown, noise = [], []
        for seed in range(self.options.seeds, self.options.seeds + frames):
            at = variation(scene, seed, size)
            truth = self._truth(at, spp)
            noise.append(truth.noise())
            shown.append({"seed": seed, "references": [str(truth.first), str(truth.second)]})
            with ThreadPoolExecutor(AT_ONCE) as pool:
                try:
                    found = list(pool.map(self._row, judged, repeat(at), repeat(truth)))
                except BaseException:
                    self.renderer.stop()  # before the pool waits for its threads
                    raise
            for method, row in zip(judged, found):
                rows[method.name].append(row)
            print(f"{scene.stem} {seed}: {_progress(rows)}", file=sys.stderr, flush=True)
        return {
            "scene": scene.stem,
            "spp": spp,
            "frames": shown,
            "reference_noise": figures.summarize(noise),
            "methods": {
                method.name: {
                    "spp": method.spp,
                    "denoiser": method.denoiser,
                    "frames": rows[method.name],
                    "figures": figures.summarize_frames(rows[method.name]),
                }
                for method in judged
            },
        }

    def _row(self, method: Method, at: Shot, truth: Truth) -> dict:
        """One method on one test frame."""
        picture = methods.make(self.renderer, method, at, truth.first)
        return {"picture": str(picture)} | figures.judge(picture, truth, method.layers)

    def _truth(self, at: Shot, spp: int) -> Truth:
        return Truth(*(self.renderer.picture(shot) for shot in methods.references(at, spp)))

    def _oidn(self) -> dict | None:
        """Error of path tracing and denoising with 1, 2, 4, ... samples, until it is that of the first network."""
        if not self.networks or not {"time", "frames"} <= self.result.keys():
            return None
        ours = self.networks[0].name
        goal = self.result["frames"]["methods"][ours]["figures"]["rse"]["mean"]
        found = {quality: self._climb(quality, goal) for quality in methods.OIDN_QUALITIES}
        return {"network": ours, "rse": goal, "ms": timing.of_frame(self.result["time"], ours), "steps": found}

    def _climb(self, quality: str, goal: float) -> list[dict]:
        steps, spp = [], 1
        while spp <= self.options.most_paths and not (steps and steps[-1]["rse"]["mean"] <= goal):
            method = methods.denoised(spp, quality)
            found = []
            for seed in range(self.options.seeds, self.options.seeds + self.options.frames):
                at = variation(self.options.scene, seed, self.options.size)
                truth = self._truth(at, self.options.spp)
                found.append(figures.rse(methods.make(self.renderer, method, at, truth.first), truth))
            steps.append(
                {"spp": spp, "ms": timing.of_paths(self.result["time"], spp, quality), "rse": figures.summarize(found)}
            )
            spp *= 2
        return steps

    def _temporal(self) -> dict:
        o = self.options
        judged = [*self.networks, methods.raster(), methods.denoised(1, "high")]
        return sequence.judge(self.renderer, o.moving, o.moving_frames, o.moving_size, o.moving_spp, judged)

    def _unseen(self) -> dict:
        o = self.options
        return {
            scene.stem: self._judge(scene, o.unseen_frames, o.size, o.unseen_spp, [*self.networks, methods.raster()])
            for scene in o.unseen
        }


def _progress(rows: dict[str, list[dict]]) -> str:
    return ", ".join(f"{name} {found[-1]['rse']:.4f}" for name, found in rows.items())


def machine() -> dict[str, object]:
    """What figures of time belong to."""
    with open("/proc/cpuinfo", encoding="ascii") as file:
        models = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    gigabytes = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30
    return {
        "cpu": models[0] if models else platform.machine(),
        "threads": len(os.sched_getaffinity(0)),
        "memory_gib": round(gigabytes),
        "system": f"{platform.system()} {platform.release()}",
    }


def alone(folder: Path, work: Callable[[int], None]) -> None:
    """Does the work of a study with the lock of its folder, whose descriptor processes that outlive it may inherit."""
    folder.mkdir(parents=True, exist_ok=True)
    with files.locked(folder / "lock", f"{folder}: another study, or a training that it began,") as held:
        work(held)


def finish(work: Callable[[], None]) -> int:
    """Does the work of a command that may be interrupted; its exit code. SIGTERM and SIGHUP are interrupts, too."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # as of nohup
        signal.signal(signal.SIGHUP, signal.default_int_handler)
    try:
        work()
    except (BadInput, files.FileError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted; the same command goes on", file=sys.stderr)
        return 130
    return 0


def main() -> int:
    """The command."""
    arguments = sys.argv[1:]
    options = parse(arguments)
    command = "tools/eval/quality " + shlex.join(arguments)
    return finish(lambda: alone(options.out, lambda _: Study(options, command).run()))


if __name__ == "__main__":
    sys.exit(main())
