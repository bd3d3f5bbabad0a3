"""tools/eval/ablations: each part of the networks left out, trained for the same time, on the same test frames.

It may be interrupted at any moment, and the same command goes on: networks that are there are not trained again, others
from their checkpoints. Where the study alone was killed, its trainings go on, and the folder is locked until they end.
"""

import argparse
import json
import os
import shlex
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from evaluation import BadInput
from lightformer_train import families, files, weights
from lightformer_train.arguments import Parser, positive

from . import quality, tables
from .renderer import ROOT, digest

TRAIN = ROOT / "tools/train/train.py"
TRAINING = "training.json"  # how the networks of a folder are trained
POLL_SECONDS = 0.2


@dataclass(frozen=True)
class Ablation:
    """A network to train."""

    preset: str
    without: str = ""

    @property
    def name(self) -> str:
        """Of its row and its file."""
        return f"{self.preset}-without-{self.without}" if self.without else self.preset


def parse(arguments: list[str]) -> tuple[argparse.Namespace, list[str]]:
    """The command line: our options, and those of tools/eval/quality."""
    parser = Parser(
        prog="tools/eval/ablations",
        description="Trains networks with one part left out each, and judges them. All other "
        "options are those of tools/eval/quality. Networks, logs and the result are written to --out.",
    )
    add = parser.add_argument
    add("data", nargs="*", type=Path, metavar="DATA", help="folder of a data set; before all options")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--minutes", type=positive, default=10, metavar="M", help="of each training (default 10)")
    length.add_argument("--steps", type=quality.positive, metavar="N", help="instead of minutes")
    add("--precision", choices=("auto", "fp32", "bf16"), default="auto", help="that of train.py (default auto)")
    add(
        "--jobs",
        type=quality.positive,
        default=1,
        metavar="N",
        help="trainings at a time, which share the processors evenly (default 1)",
    )
    add(
        "--presets",
        nargs="+",
        choices=families.PRESETS,
        default=["structured-small", "paper-small"],
        metavar="PRESET",
        help="families at their widths (default: structured-small paper-small)",
    )
    add("--only", nargs="+", metavar="PART", help="leave out only these parts, or networks of --list; none: no part")
    add("--list", action="store_true", help="print the names of the networks and do nothing")
    add("--out", type=Path, default=ROOT / "out/ablations", metavar="DIR", help="default out/ablations")
    options, others = parser.parse_known_args(arguments)
    if not options.data and not options.list:
        parser.error("the following arguments are required: DATA")
    try:
        options.chosen = choose(options.presets, options.only)
    except ValueError as error:
        parser.error(str(error))
    return options, others


def choose(presets: list[str], only: list[str] | None) -> list[Ablation]:
    """Each preset whole and without each of its parts, or those of them that are named."""
    every = [Ablation(preset, part) for preset in presets for part in ("", *families.parts(preset))]
    unknown = set(only or ()) - {"none"} - {word for a in every for word in (a.without, a.name)}
    if unknown:
        raise ValueError(f"--only {min(unknown)}: no part of {', '.join(presets)}; --list shows what there is")
    return [a for a in every if not a.without or only is None or {a.without, a.name} & set(only)]


def file_of(ablation: Ablation, options: argparse.Namespace) -> Path:
    """Where a network is, or will be."""
    return options.out / f"{ablation.name}.safetensors"


# ---- training


def conditions(options: argparse.Namespace) -> dict:
    """What all networks of a folder have in common."""
    processors = len(os.sched_getaffinity(0))
    return {
        "data": [[folder.name, digest(folder / "manifest.json")] for folder in options.data],
        "length": f"{options.steps} steps" if options.steps else f"{options.minutes:g} minutes",
        "precision": options.precision,
        "jobs": options.jobs,
        "threads": max(1, processors // options.jobs),
    }


def agree(options: argparse.Namespace) -> dict:
    """Refuses to mix networks that were trained in different ways."""
    wanted, path = conditions(options), options.out / TRAINING
    if not path.exists():
        files.write_atomically(path, json.dumps(wanted, indent=1).encode())
    earlier = {"precision": "auto"} | quality.read_json(path)  # of a study that did not say
    differing = [key for key, value in wanted.items() if earlier.get(key) != value]
    if differing:
        found = ", ".join(f"{key} {earlier.get(key)}" for key in differing)
        raise BadInput(f"{options.out}: its networks are trained otherwise ({found}); choose another --out")
    return wanted


def start(ablation: Ablation, options: argparse.Namespace, threads: int, held: int) -> subprocess.Popen:
    """Begins or goes on with a training, which says what it does in a log. --force: its network is not there, but the
    report of one that was removed may be."""
    output = file_of(ablation, options)
    length = ["--steps", str(options.steps)] if options.steps else ["--minutes", f"{options.minutes:g}"]
    arguments = [*map(str, options.data), "-o", str(output), "--preset", ablation.preset, *length]
    arguments += ["--threads", str(threads), "--precision", options.precision, "--force"]
    arguments += ["--without", ablation.without] if ablation.without else []
    arguments += ["--resume"] if output.with_suffix(".checkpoint").exists() else []
    print(f"training {ablation.name}: {log_of(ablation, options)}", file=sys.stderr, flush=True)
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    with open(log_of(ablation, options), "a", encoding="utf-8") as log:
        return subprocess.Popen(
            [TRAIN, *arguments], stdout=log, stderr=subprocess.STDOUT, env=environment, pass_fds=[held]
        )


def log_of(ablation: Ablation, options: argparse.Namespace) -> Path:
    """What its training says."""
    return options.out / f"{ablation.name}.log"


def train(chosen: list[Ablation], options: argparse.Namespace, threads: int, held: int) -> None:
    """All networks that are not there yet, several at a time; each inherits the descriptor `held`."""
    waiting = [ablation for ablation in chosen if not file_of(ablation, options).exists()]
    running: dict[subprocess.Popen, Ablation] = {}
    try:
        while waiting or running:
            while waiting and len(running) < options.jobs:
                ablation = waiting.pop(0)
                running[start(ablation, options, threads, held)] = ablation
            time.sleep(POLL_SECONDS)
            for process in [process for process in running if process.poll() is not None]:
                check(process, running.pop(process), options)
    finally:
        for process in running:
            process.terminate()  # it leaves a checkpoint
        for process in running:
            process.wait()


def check(process: subprocess.Popen, ablation: Ablation, options: argparse.Namespace) -> None:
    """Of a training that has ended."""
    if process.returncode == 0:
        return
    lines = log_of(ablation, options).read_text(encoding="utf-8").strip().splitlines()
    raise BadInput(lines[-1] if lines else f"{TRAIN}: exit code {process.returncode}")


def steps_of(notes: dict[str, str]) -> int | None:
    """How many steps a network was trained for, by its own account."""
    words = shlex.split(notes.get("training", ""))
    return int(words[words.index("--steps") + 1]) if "--steps" in words[:-1] else None


def study(options: argparse.Namespace, judging: argparse.Namespace, chosen: list[Ablation], held: int) -> None:
    """Trains, then judges. What judging would refuse is refused before."""
    common = agree(options)
    paths = {ablation.name: file_of(ablation, options) for ablation in chosen}
    known = {name: digest(path) if path.exists() else "" for name, path in paths.items()}
    quality.earlier_result(judging, quality.settings_of(judging, known))
    train(chosen, options, common["threads"], held)
    notes = {name: weights.read_header(path)[1] for name, path in paths.items()}
    told = {
        "steps": {name: steps_of(found) for name, found in notes.items()},
        "products": sorted({found["precision"] for found in notes.values() if "precision" in found}),
    }
    command = "tools/eval/ablations " + shlex.join(sys.argv[1:])
    judged = quality.Study(judging, command, {"training": common | told})
    judged.run()
    print(f"\n{tables.text(tables.of_ablations(judged.result))}")


def main() -> int:
    """The command."""
    options, others = parse(sys.argv[1:])
    chosen = options.chosen
    if options.list:
        print("\n".join(ablation.name for ablation in chosen))
        return 0
    networks = [f"{ablation.name}={file_of(ablation, options)}" for ablation in chosen]
    judging = quality.parse([*networks, *others, "--only-networks", "--parts", "frames", "--out", str(options.out)])
    return quality.finish(lambda: quality.alone(options.out, lambda held: study(options, judging, chosen, held)))


if __name__ == "__main__":
    sys.exit(main())
