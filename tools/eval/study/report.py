"""tools/eval/report: what studies found, as one HTML file: pictures to compare, all tables, commands, the machine."""

import argparse
import html
import sys
from pathlib import Path

from evaluation import BadInput, page, perceptual
from evaluation.comparison import Comparison, prepare
from evaluation.pictures import load
from lightformer_train.arguments import Parser, whole
from lightformer_train.files import FileError

from . import tables
from .figures import WHOLE, Truth
from .quality import RESULT, read_json
from .renderer import ROOT
from .tables import Table

MANTISSA = 7  # bits of what is shown: half a percent, and half the size of the file
TITLE = "LightFormer: quality"


def parse() -> argparse.Namespace:
    """The command line."""
    parser = Parser(
        prog="tools/eval/report",
        description="Makes one HTML file of what tools/eval/quality found, with its pictures inside.",
    )
    add = parser.add_argument
    add(
        "study",
        type=Path,
        nargs="?",
        default=ROOT / "out/quality",
        metavar="DIR",
        help="of tools/eval/quality (default out/quality)",
    )
    add(
        "--ablations",
        type=Path,
        metavar="DIR",
        help="of tools/eval/ablations (default: ablations beside DIR, if there)",
    )
    add("--bench", type=Path, nargs="*", default=[], metavar="FILE", help="what `lightformer bench --json` printed")
    add(
        "--show",
        type=whole(1),
        default=2,
        metavar="N",
        help="test frames with pictures (default 2); one of each other scene",
    )
    add("-o", "--output", type=Path, metavar="FILE", help="default DIR/report.html")
    add("--force", action="store_true", help="overwrite a file of that name that is no report of this study")
    return parser.parse_args()


# ---- pictures


def frames(result: dict, count: int) -> list[dict]:
    """What the viewer shows: test frames, one of each unseen scene, the last one of the sequence."""
    shown = _of_scene(result["frames"], count) if "frames" in result else []
    for part in result.get("unseen", {}).values():
        shown += _of_scene(part, 1)
    if "temporal" in result:
        shown.append(_of_sequence(result["temporal"]))
    return shown


def _of_scene(part: dict, count: int) -> list[dict]:
    return [
        _frame(
            f"{part['scene']} {about['seed']}",
            f"reference, 2 x {part['spp']} spp",
            Truth(*map(Path, about["references"])),
            {name: method["frames"][i] for name, method in part["methods"].items()},
        )
        for i, about in enumerate(part["frames"][:count])
    ]


def _frame(name: str, reference: str, truth: Truth, methods: dict[str, dict]) -> dict:
    pictures = [_picture(method, truth.compare(Path(found["picture"])), found) for method, found in methods.items()]
    return page.frame(name, reference, pictures, MANTISSA)


def _picture(name: str, comparison: Comparison, values: dict) -> page.Shown:
    return page.Shown(name, comparison, WHOLE, values, {"hdr_flip": perceptual.hdr_flip_map(comparison)})


def _of_sequence(part: dict) -> dict:
    pictures = [
        _picture(name, prepare(load(method["picture"]), load(method["reference"])), {})
        for name, method in part["methods"].items()
        if name != "reference"
    ]
    return page.frame(f"{part['scene']}, moving", f"reference, {part['spp']} spp", pictures, MANTISSA)


# ---- text


def sections(study: dict, ablations: dict | None, benches: list[tuple[str, dict]]) -> str:
    """All that is below the pictures."""
    found = [*tables.summary(study), *tables.of_study(study)]
    if ablations:
        found += tables.of_ablations(ablations)
    for name, bench in benches:
        found += tables.of_bench(name, bench)
    found += [*tables.of_making(study, ablations), _files(study)]
    return "\n".join(["<article>", *map(tables.markup, found), _commands(study, ablations), "</article>"])


def _files(study: dict) -> Table:
    settings = study["settings"]
    rows = [
        ["scene", f"{settings['scene']}, {settings['scene_hash']}"],
        *([f"network {name}", key] for name, key in settings["networks"].items()),
    ]
    return Table("Files", "By the first 64 bits of their SHA-256.", ["", ""], rows)


def _commands(study: dict, ablations: dict | None) -> str:
    """Each once, behind the parts that it made."""
    parts: dict[str, list[str]] = {}
    for name, part in tables.making(study, ablations).items():
        parts.setdefault(part["command"], []).append(name)
    lines = "\n".join(f"# {', '.join(names)}\n{command}" for command, names in parts.items())
    return f"<section><h2>Commands</h2>\n<pre>{html.escape(lines)}\ntools/eval/report</pre></section>"


def main() -> int:
    """The command."""
    options = parse()
    beside = options.study.parent / "ablations"
    try:
        study = read_json(options.study / RESULT)
        chosen = options.ablations or (beside if (beside / RESULT).exists() else None)
        ablations = read_json(chosen / RESULT) if chosen else None
        benches = [(path.stem, read_json(path)) for path in options.bench]
        output, about = options.output or options.study / "report.html", page.about(study["settings"])
        if not options.force:
            page.refuse_to_overwrite(output, about)  # before pictures are read
        shown = frames(study, options.show)
        if not shown:
            raise BadInput(f"{options.study}: no pictures yet: run tools/eval/quality with the part frames")
        text = sections(study, ablations, benches)
        page.write_page(output, TITLE, shown, sections=text, about=about, force=options.force)
        print(output)
    except (BadInput, FileError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyError as error:
        print(f"error: {options.study}: its result lacks {error}; run tools/eval/quality again", file=sys.stderr)
        return 1
    except (AttributeError, IndexError, TypeError, ValueError):
        print(f"error: {options.study}: it, or what else is to be shown, is no result of a study", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
