"""tools/eval/compare: figures of a picture, or of each frame of a sequence, against its reference."""

import argparse
import json
import re
import sys
from pathlib import Path

from lightformer_train.arguments import Parser
from lightformer_train.files import FileError

from . import BadInput, lpips, metrics, page, perceptual
from .comparison import prepare
from .pictures import load
from .temporal import read_motion, temporal_error

# Key, name, and how many digits tell something. The order of text, table and page.
FIGURES = (
    ("rse", "RSE", "{:.6g}"),
    ("l1", "L1", "{:.6g}"),
    ("psnr", "PSNR (dB)", "{:.2f}"),
    ("mean_ratio", "mean ratio", "{:.5f}"),
    ("ssim", "SSIM", "{:.4f}"),
    ("ms_ssim", "MS-SSIM", "{:.4f}"),
    ("flip", "FLIP", "{:.4f}"),
    ("hdr_flip", "HDR-FLIP", "{:.4f}"),
    ("lpips", "LPIPS", "{:.4f}"),
    ("temporal", "temporal", "{:.6g}"),
)


def parse_arguments(arguments):
    parser = Parser(prog="tools/eval/compare", description="Measures how far a picture is from its "
                    "reference; tools/eval/README.md says what each figure means.")
    parser.add_argument("a", metavar="A", help="the picture that is judged, OpenEXR or PNG")
    parser.add_argument("b", metavar="B", help="its reference")
    parser.add_argument("b2", metavar="B2", nargs="?",
                        help="a second reference, made with another seed: removes the noise of both from the RSE")
    parser.add_argument("--layer", metavar="NAME", help="compare this layer of OpenEXR files, such as indirect")
    parser.add_argument("--mask", metavar="FILE", help="only pixels where this picture is not 0")
    parser.add_argument("--mask-layer", metavar="NAME", help="the mask is this layer, of B unless --mask names a file")
    parser.add_argument("--frames", metavar="FIRST..LAST", type=frame_range,
                        help="a numbered sequence: name.exr stands for name.0000.exr and so on; adds the temporal error")
    parser.add_argument("--html", metavar="DIR", help="write a page to look at, DIR/index.html")
    parser.add_argument("--force", action="store_true", help="overwrite a file of that name that is no page of A and B")
    parser.add_argument("--json", action="store_true", help="print JSON")
    values = parser.parse_args(arguments)
    if values.html and values.frames:
        parser.error("--html shows one picture: it and --frames exclude each other")
    return values


def frame_range(text):
    match = re.fullmatch(r"(\d+)\.\.(\d+)", text)
    if not match or int(match[1]) > int(match[2]):
        raise argparse.ArgumentTypeError(f'"{text}" is not FIRST..LAST')
    return range(int(match[1]), int(match[2]) + 1)


def numbered(path, frame):
    """The name of one frame of a sequence, as `lightformer render --frames` writes it."""
    if path is None or frame is None:
        return path
    stem, dot, extension = path.rpartition(".")
    return f"{stem}.{frame:04}{dot}{extension}"


def load_comparison(options, frame=None):
    a, b, b2, mask = (numbered(path, frame) for path in (options.a, options.b, options.b2, options.mask))
    masked = mask or options.mask_layer
    return prepare(load(a, options.layer), load(b, options.layer), b2 and load(b2, options.layer),
                   load(mask or b, options.mask_layer) if masked else None)


def mean_of_map(c, values):
    return None if values is None else float(values[c.mask].mean())


def measure(c):
    """Every figure of one picture, and the maps that the page shows."""
    maps = {"flip": perceptual.flip_map(c), "hdr_flip": perceptual.hdr_flip_map(c)}
    figures = metrics.compute(c) | {
        "ssim": perceptual.ssim(c),
        "ms_ssim": perceptual.ms_ssim(c),
        "flip": mean_of_map(c, maps["flip"]),
        "hdr_flip": mean_of_map(c, maps["hdr_flip"]),
        "lpips": lpips.lpips(c),
    }
    return figures, maps


def describe(options):
    return {"a": options.a, "b": options.b, "b2": options.b2, "layer": options.layer}


def compare_pictures(options):
    c = load_comparison(options)
    figures, maps = measure(c)
    if options.html:
        picture = page.Shown(options.a, c, FIGURES, figures, maps)
        page.write_page(Path(options.html) / "index.html", f"{options.a} against {options.b}",
                        [page.frame(options.b, options.b, [picture])], options.layer, c.b.display,
                        about=page.about(describe(options)), force=options.force)
    return describe(options) | figures | {"pixels": int(c.mask.sum())}


def compare_sequence(options):
    """The figures of each frame, and their means; the first frame has no temporal error."""
    frames, before = [], None
    for frame in options.frames:
        c = load_comparison(options, frame)
        motion, entities = read_motion(numbered(options.b, frame))
        temporal = temporal_error(before[0], c, motion, before[1], entities) if before else None
        frames.append({"frame": frame} | measure(c)[0] | {"temporal": temporal})
        before = c, entities
    return describe(options) | mean_figures(frames) | {"frames": frames}


def mean_figures(frames):
    """Means over the frames that have the figure."""
    means = {}
    for key, _, _ in FIGURES:
        values = [frame[key] for frame in frames if frame[key] is not None]
        means[key] = sum(values) / len(values) if values else None
    return means


def print_figures(result):
    for key, name, digits in FIGURES:
        if key in result:
            print(f"{name:11} {'-' if result[key] is None else digits.format(result[key])}")


def main():
    options = parse_arguments(sys.argv[1:])
    try:
        result = compare_sequence(options) if options.frames else compare_pictures(options)
    except (BadInput, FileError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    if options.json:
        print(json.dumps(result, indent=2))
    else:
        print_figures(result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
