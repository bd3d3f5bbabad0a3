"""What a study found, as tables: the same for a terminal and for the report."""

import html
from collections.abc import Callable
from dataclasses import dataclass

from . import timing
from .figures import COMPONENTS, WHOLE

NOTHING = "–"


@dataclass(frozen=True)
class Table:
    """Cells are text; the first column names the row."""

    title: str
    note: str
    head: list[str]
    rows: list[list[str]]


def text(tables: list[Table]) -> str:
    """For a terminal."""
    return "\n\n".join(_text(table) for table in tables)


def _text(table: Table) -> str:
    lines = [table.head, *table.rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(table.head))]
    shown = [
        "  ".join(cell.rjust(width) if i else cell.ljust(width) for i, (cell, width) in enumerate(zip(line, widths)))
        for line in lines
    ]
    return "\n".join([table.title, *(line.rstrip() for line in shown), table.note])


def markup(table: Table) -> str:
    """For a page."""

    def row(cells: list[str], tag: str) -> str:
        first, *others = (html.escape(cell) for cell in cells)
        return f'<tr><th scope="row">{first}</th>' + "".join(f"<{tag}>{cell}</{tag}>" for cell in others) + "</tr>"

    body = "\n".join(row(cells, "td") for cells in table.rows)
    return (
        f"<section><h2>{html.escape(table.title)}</h2>\n<table>\n<thead>{row(table.head, 'th')}</thead>\n"
        f"<tbody>\n{body}\n</tbody>\n</table>\n<p>{html.escape(table.note)}</p></section>"
    )


def number(summary: dict | None, digits: str) -> str:
    """A mean and half its confidence interval."""
    if summary is None:
        return NOTHING
    half = summary["half"]
    return digits.format(summary["mean"]) + ("" if half is None else f" ± {digits.format(half)}")


# ---- parts of the result of tools/eval/quality


def made(result: dict, part: str) -> dict:
    """What made a part: `command`, `machine` and the hash of the `program`. Results that have these once for all parts
    are of the last run, and do not know the program."""
    once = {key: result.get(key) for key in ("command", "machine", "program")}
    return result.get("made", {}).get(part, once)


def making(result: dict, ablations: dict | None = None) -> dict[str, dict]:
    """What made each part of a study, and its ablations."""
    found = {name: made(result, name) for name in PARTS if name in result}
    return found | ({"ablations": made(ablations, "frames")} if ablations else {})


def of_making(result: dict, ablations: dict | None = None) -> list[Table]:
    """The same."""
    rows = []
    for name, part in making(result, ablations).items():
        machine = part["machine"]
        about = [processor(machine), f"{machine['memory_gib']} GiB", machine["system"]]
        rows.append([name, part["program"] or NOTHING, *about])
    note = "Programs by the first 64 bits of their SHA-256."
    if len({tuple(row[1:]) for row in rows}) > 1:
        note += " Not all parts are of one program and machine; --parts makes one of them anew."
    return [Table("Made by", note, ["part", "program", "processor", "memory", "system"], rows)]


def processor(machine: dict) -> str:
    """Of a part."""
    return f"{machine['cpu']}, {machine['threads']} threads"


def _time(result: dict) -> list[Table]:
    times, settings = result["time"], result["settings"]
    rows = [["a sample a pixel of path tracing", f"{times['sample']:.1f}"]]
    rows += [
        [f"a frame, {key.partition(':')[2]}", f"{ms:.1f}"] for key, ms in times.items() if key.startswith("frame:")
    ]
    rows += [
        [f"Open Image Denoise, {key.partition(':')[2]}", f"{ms:.1f}"]
        for key, ms in times.items()
        if key.startswith("oidn:")
    ]
    return [
        Table(
            f"Time at {times['size']} x {times['size']}",
            "Frames in which everything is redone, and samples in turns "
            f"with them. The {settings['frames']} test frames' references take {_hours(times, settings):.1f} hours. "
            f"{processor(made(result, 'time')['machine'])}.",
            ["what", "ms"],
            rows,
        )
    ]


def _hours(times: dict, settings: dict) -> float:
    """Of tracing both references of all test frames."""
    return 2 * settings["frames"] * timing.of_paths(times, settings["spp"]) / 3.6e6


def _milliseconds(result: dict, name: str, method: dict) -> str:
    times = result.get("time")
    if not times or times["size"] != result["settings"]["size"]:
        return NOTHING
    if method["spp"]:
        return f"{timing.of_paths(times, method['spp'], method['denoiser']):.0f}"
    return f"{timing.of_frame(times, name):.0f}" if f"frame:{name}" in times else NOTHING


def _frames(result: dict) -> list[Table]:
    part = result["frames"]
    methods, count = part["methods"], len(part["frames"])
    noise = number(part["reference_noise"], "{:.5f}")
    whole = [
        [
            name,
            _milliseconds(result, name, method),
            *(number(method["figures"][key], digits) for key, _, digits in WHOLE),
        ]
        for name, method in methods.items()
    ]
    settings = result["settings"]
    return [
        Table(
            f"Quality on {count} test frames of {part['scene']}, {settings['size']} x {settings['size']}",
            f"Means over frames, 95 % confidence intervals. RSE by two references of {part['spp']} spp each, one of "
            f"which alone has an RSE of {noise}.",
            ["method", "ms", *(name for _, name, _ in WHOLE)],
            whole,
        ),
        *(_components(methods, key, title) for key, title in (("rse", "RSE"), ("mean_ratio", "Mean ratio"))),
    ]


def _components(methods: dict, key: str, title: str) -> Table:
    rows = [
        [name, *(number(_component(method["figures"], layer, key), "{:.4f}") for layer in COMPONENTS)]
        for name, method in methods.items()
        if method["figures"]["layers"]
    ]
    return Table(
        f"{title} of components",
        "T_l: direct light without shadows, T_d: with them, T_i: all other light.",
        ["method", *COMPONENTS.values()],
        rows,
    )


def _component(figures: dict, layer: str, key: str) -> dict | None:
    return figures[key] if layer == "beauty" else figures["layers"].get(layer, {}).get(key)


def _oidn(result: dict) -> list[Table]:
    part = result["oidn"]
    rows, found = [], []
    for quality, steps in part["steps"].items():
        rows += [
            [
                f"{step['spp']} spp + OIDN {quality}",
                f"{step['ms']:.0f}",
                f"{step['ms'] / part['ms']:.2f}",
                number(step["rse"], "{:.5f}"),
            ]
            for step in steps
        ]
        last = steps[-1]
        reached = last["rse"]["mean"] <= part["rse"]
        found.append(f"{quality} {'' if reached else 'more than '}{last['ms'] / part['ms']:.1f}")
    return [
        Table(
            f"Path tracing and Open Image Denoise until they reach {part['network']}",
            f"{part['network']}: {part['ms']:.0f} ms, RSE {part['rse']:.5f}. Times as long for its error: "
            f"{'; '.join(found)}.",
            ["method", "ms", f"times {part['network']}", "RSE"],
            rows,
        )
    ]


def _temporal(result: dict) -> list[Table]:
    part = result["temporal"]
    rows = [
        [name, number(method["change"], "{:.4f}"), f"{method['ratio']:.3f}", number(method["temporal_error"], "{:.4f}")]
        for name, method in part["methods"].items()
    ]
    return [
        Table(
            f"Flicker over {part['frames']} frames of {part['scene']}, {part['size']} x {part['size']}",
            "Change: mean |X_t - warp(X_(t-1))| over the reference's mean; ratio: to that of the reference, "
            f"{part['spp']} spp. Temporal error: the same of what differs from the reference; the second reference "
            "shows how much of it is noise.",
            ["method", "change", "ratio", "temporal error"],
            rows,
        )
    ]


def _unseen(result: dict) -> list[Table]:
    parts, known = result["unseen"], result.get("frames", {}).get("methods", {})
    rows = []
    for scene, part in parts.items():
        for name, method in part["methods"].items():
            rows.append(
                [
                    f"{scene}: {name}",
                    number(method["figures"]["rse"], "{:.5f}"),
                    _times(method["frames"], known[name]["frames"]) if name in known else NOTHING,
                    number(method["figures"]["hdr_flip"], "{:.4f}"),
                    number(method["figures"]["mean_ratio"], "{:.4f}"),
                ]
            )
    return [
        Table(
            "Scenes with something that no training showed",
            "Times: RSE over that of the scene it was trained on, same variations. References: "
            + ", ".join(sorted({f"2 x {part['spp']} spp" for part in parts.values()}))
            + ", whose noise HDR-FLIP sees.",
            ["scene: method", "RSE", "times", "HDR-FLIP", "mean ratio"],
            rows,
        )
    ]


def _times(unseen: list[dict], known: list[dict]) -> str:
    """Over the same variations of the known scene."""
    pairs = list(zip(unseen, known))
    return f"{sum(frame['rse'] for frame, _ in pairs) / sum(frame['rse'] for _, frame in pairs):.2f}"


PARTS: dict[str, Callable[[dict], list[Table]]] = {
    "time": _time,
    "frames": _frames,
    "oidn": _oidn,
    "temporal": _temporal,
    "unseen": _unseen,
}


def of_study(result: dict) -> list[Table]:
    """All tables of a result."""
    return [table for name, part in PARTS.items() if name in result for table in part(result)]


# ---- beside that of a study


def summary(result: dict) -> list[Table]:
    """The first network at a glance, with what it should reach."""
    if not result["settings"]["networks"] or "frames" not in result:
        return []
    ours = next(iter(result["settings"]["networks"]))
    rows = _at_a_glance(ours, result["frames"]["methods"])
    for key, figure in (("rse", "RSE"), ("hdr_flip", "HDR-FLIP")):
        rows += [
            _goal(f"{figure} over that of {name}", figures[key], 1, "{:.3f}") for name, figures in _rivals(result, ours)
        ]
    rows += _reversed(result, ours)
    if "temporal" in result:
        rows.append(
            _goal(
                "change from frame to frame over that of the reference",
                result["temporal"]["methods"][ours]["ratio"],
                1.1,
                "{:.3f}",
            )
        )
    for scene, part in result.get("unseen", {}).items():
        times = float(_times(part["methods"][ours]["frames"], result["frames"]["methods"][ours]["frames"]))
        rows.append(_goal(f"RSE on {scene} over that on {result['settings']['scene']}", times, 2, "{:.2f}"))
    return [
        Table(
            f"At a glance: {ours}",
            "Beside path tracing with as many samples as take the same time, and one sample denoised.",
            ["", "measured", "at most", ""],
            rows,
        )
    ]


def _goal(what: str, value: float, most: float, digits: str) -> list[str]:
    return [what, digits.format(value), f"{most:g}", "reached" if value <= most else "missed"]


def _at_a_glance(ours: str, methods: dict) -> list[list[str]]:
    figures = methods[ours]["figures"]
    return [
        _goal("RSE", figures["rse"]["mean"], 0.05, "{:.4f}"),
        _goal("HDR-FLIP", figures["hdr_flip"]["mean"], 0.12, "{:.4f}"),
    ]


def _reversed(result: dict, ours: str) -> list[list[str]]:
    """The other way round: the time of path tracing and denoising at our error. Where no number of samples reached it,
    that of the most that were tried, which flatters the rival."""
    part = result.get("oidn")
    if not part or part["network"] != ours:
        return []
    return [
        _goal(f"time over that of paths + OIDN {quality} at the same RSE", part["ms"] / steps[-1]["ms"], 1, "{:.2f}")
        for quality, steps in part["steps"].items()
    ]


def _rivals(result: dict, ours: str) -> list[tuple[str, dict[str, float]]]:
    """Our errors over those of what a user would pick instead: most paths in our time, one path denoised."""
    methods = result["frames"]["methods"]
    names = [name for name, method in methods.items() if method["denoiser"]]
    times = result.get("time")
    if times and f"frame:{ours}" in times:
        fitting = timing.paths_that_fit(times, timing.of_frame(times, ours))
        names = [
            name for name, method in methods.items() if method["spp"] == fitting and not method["denoiser"]
        ] + names
    own = methods[ours]["figures"]
    return [
        (name, {key: own[key]["mean"] / methods[name]["figures"][key]["mean"] for key in ("rse", "hdr_flip")})
        for name in names
    ]


def of_ablations(result: dict) -> list[Table]:
    """Each network beside the whole one of its family, which comes before its ablations."""
    rows, whole = [], None
    training = result["training"]
    for name, method in result["frames"]["methods"].items():
        rse, flip, ratio = (method["figures"][key] for key in ("rse", "hdr_flip", "mean_ratio"))
        if "-without-" not in name:
            whole = rse["mean"]
        rows.append(
            [
                name,
                str(training["steps"][name]),
                number(rse, "{:.5f}"),
                f"{rse['mean'] / whole:.2f}" if whole else NOTHING,
                number(flip, "{:.4f}"),
                number(ratio, "{:.4f}"),
            ]
        )
    settings = result["settings"]
    return [
        Table(
            "Ablations",
            f"Each trained for {training['length']}, {training['jobs']} at a time, "
            f"{training['threads']} thread{'s' if training['threads'] > 1 else ''} each, products in "
            f"{' or '.join(training.get('products', [])) or 'a precision that is not told'}; "
            f"{settings['frames']} test frames of {settings['size']} x {settings['size']}. Times: RSE over that of the "
            "whole network.",
            ["network", "steps", "RSE", "times", "HDR-FLIP", "mean ratio"],
            rows,
        )
    ]


def of_bench(name: str, bench: dict) -> list[Table]:
    """What `lightformer bench --json` printed: passes and ratios of frames; plain numbers of anything else."""
    found = []
    if "passes" in bench:
        rows = [["frame", f"{bench['frame_ms']['median']:.2f}", NOTHING]]
        rows += [[one["name"], f"{one['cpu_ms']:.2f}", f"{one['gpu_ms']:.2f}"] for one in bench["passes"]]
        found.append(
            Table(
                f"Time of each pass: {name}",
                f"{bench['scene']}, {bench['width']} x {bench['height']}, "
                f"{bench['frames']} frames on {bench['device']}; {bench['memory_mib']:.0f} MiB.",
                ["pass", "CPU ms", "GPU ms"],
                rows,
            )
        )
    if "neural" in bench:
        rows = [
            [stage, f"{ms:.2f}", f"{100 * ms / bench['neural']['frame_ms']:.1f} %"]
            for stage, ms in bench["neural"]["budget_ms"].items()
        ]
        found.append(
            Table(
                f"Budget of a frame: {name}",
                f"Everything redone, {bench['neural']['frame_ms']:.1f} ms; a sample a "
                f"pixel of path tracing in turns with it, {bench['neural']['sample_ms']:.1f} ms.",
                ["stage", "ms", "share"],
                rows,
            )
        )
        found += _growth(name, bench["neural"])
    plain = {key: value for key, value in bench.items() if isinstance(value, (int, float)) and "passes" not in bench}
    rows = [[key, f"{value:.4g}"] for key, value in (plain | bench.get("ratios", {})).items()]
    if rows:
        found.append(Table(f"Ratios: {name}", "Each measured within one run.", ["", ""], rows))
    return found


def _growth(name: str, neural: dict) -> list[Table]:
    """What lights and pieces cost; nothing if only a frame was measured."""
    if "lights" not in neural:
        return []
    rows = [
        [f"{step['count']} {what}", *(f"{step[key]:.1f}" for key in ("encode_ms", "gather_ms", "network_ms"))]
        for what in ("lights", "pieces")
        for step in neural[what]
    ]
    note = (
        f"A light more: {neural['encode_slope_ms']:.1f} ms to encode, {neural['gather_slope_ms']:.1f} ms to gather. "
        f"Peak memory with 7 lights {neural['memory_mib']:.0f} MiB; first picture after "
        f"{neural['first_frame_s']:.1f} s."
    )
    return [Table(f"Lights and pieces: {name}", note, ["", "encode ms", "gather ms", "network ms"], rows)]
