"""tools/eval/clues: what the inputs of a network are worth before it sees them, kind of surface by kind of surface.

The share that each kind has in the RSE of the whole picture (so shares add up), if nothing but clues made it: T_d by
`view.diffuse` and `view.glossy` times what arrives of them; T_i of metals by F0 times what their rays see, of others by
albedo times the light of RSM texels or of rays over the hemisphere, each times its best factor.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evaluation import BadInput
from lightformer_train import weights
from lightformer_train.arguments import Parser

from . import methods, tables
from .figures import Truth
from .quality import finish, positive, seed
from .renderer import PROGRAM, ROOT, Renderer, variation

METAL, SMOOTH = 0.2, 0.5  # F0 above which, roughness below which (lightformer/clues)
SIZE = 512  # pixels a side, as dataset makes whole pictures


@dataclass(frozen=True)
class Clues:
    """Inputs of one frame: planes [channels, h, w]."""

    tensors: dict[str, np.ndarray]

    def of(self, name: str) -> np.ndarray:
        """An input, without the dimension of its frame."""
        return self.tensors[name].astype(np.float32)[0]

    def summed(self, light: np.ndarray) -> np.ndarray:
        """Radiance of all lights, of planes [lights, 3, h, w]."""
        share = self.tensors["light.share"].astype(np.float32)[..., None, None]
        return (light * share).sum(0) * self.unit

    @property
    def unit(self) -> np.ndarray:
        """frame.radiance"""
        return self.tensors["frame.radiance"].astype(np.float32).reshape(-1, 1, 1)

    def direct(self) -> np.ndarray:
        """T_d"""
        lobes = (self.of(f"view.{lobe}") * self.of(f"view.{lobe}_reached") for lobe in ("diffuse", "glossy"))
        return self.summed(sum(lobes))

    def reflected(self) -> np.ndarray:
        """T_i of metals."""
        return self.of("pixel.specular") * self.of("pixel.mirror_light") * self.unit

    def diffused(self, clue: str) -> np.ndarray:
        """T_i of others."""
        light = self.of(clue) * self.unit if clue.startswith("pixel.") else self.summed(self.of(clue))
        return self.of("pixel.diffuse") * light

    def surfaces(self) -> dict[str, np.ndarray]:
        """Masks [h, w] by kind."""
        there = self.of("pixel.mask")[0] > 0
        metal = self.of("pixel.specular").max(0) > METAL
        smooth = self.of("pixel.roughness")[0] < SMOOTH
        return {
            "metals": there & metal,
            "glossy dielectrics": there & ~metal & smooth,
            "rough dielectrics": there & ~metal & ~smooth,
        }


def encode(renderer: Renderer, scene: Path, seed: int) -> Clues:
    """Computed by `lightformer dataset` as for a training."""
    folder = renderer.folder / f"{renderer.path(variation(scene, seed, SIZE)).stem}-clues-{renderer.version}"
    arguments = f"--seed {seed} --count 1 --crop 0 --crops 1 --spp 1".split()
    renderer.run("dataset", str(scene), "-o", str(folder), *arguments)
    shards = list(folder.glob("*.safetensors"))
    if not shards:
        raise BadInput(f"{folder}: no shard of a data set is there; is {renderer.program} lightformer?")
    tensors, _ = weights.map_tensors(shards[0])
    return Clues({name.partition("/")[2]: value for name, value in tensors.items()})


class Judge:
    """Of one frame."""

    def __init__(self, truth: Truth) -> None:
        self.whole = self._planes(truth, "beauty")
        self.layers = {layer: self._planes(truth, layer) for layer in ("direct", "indirect")}
        self.unit = self.whole.mean()
        self.weight = 1 / (self.whole**2 + 0.01 * self.unit**2)

    @staticmethod
    def _planes(truth: Truth, layer: str) -> np.ndarray:
        compared = truth.compare(truth.first, layer)
        return np.moveaxis(0.5 * (compared.b.pixels + compared.b2.pixels), -1, 0)

    def rse(self, ours: np.ndarray, layer: str, mask: np.ndarray) -> float:
        """Part of the picture's, with the layer's mean of two references as the truth."""
        return float((((ours - self.layers[layer]) ** 2 * self.weight).mean(0) * mask).mean())

    def fitted(self, ours: np.ndarray, layer: str, mask: np.ndarray) -> str:
        """The same with the factor that makes it least."""
        weight = self.weight * mask
        factor = (ours * self.layers[layer] * weight).sum() / max((ours**2 * weight).sum(), 1e-20)
        return f"{self.rse(factor * ours, layer, mask):.5f} (x {factor:.2f})"


def judge(clues: Clues, truth: Truth, title: str) -> tables.Table:
    """One frame."""
    found, rows = Judge(truth), []
    for name, mask in clues.surfaces().items():
        row = [name, f"{mask.mean():.3f}", f"{found.rse(clues.direct(), 'direct', mask):.5f}"]
        if name == "metals":
            row += [found.fitted(clues.reflected(), "indirect", mask), tables.NOTHING, tables.NOTHING]
        else:
            by = (found.fitted(clues.diffused(clue), "indirect", mask) for clue in ("view.bounce", "pixel.gathered"))
            row += [tables.NOTHING, *by]
        rows.append(row)
    head = ["surfaces", "of all pixels", "T_d", "T_i: reflections", "T_i: texels", "T_i: hemisphere"]
    return tables.Table(title, "parts of the picture's RSE; in brackets the factors that make them least", head, rows)


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line."""
    parser = Parser(
        prog="tools/eval/clues", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--scene", type=Path, default=ROOT / "content/chess/chess.glb", metavar="FILE", help="default: Chess")
    add("--seeds", type=seed, nargs="+", default=[900000, 900001], metavar="SEED", help="variations (two by default)")
    add("--spp", type=positive, default=512, metavar="N", help="of each of the two references (default 512)")
    add("--program", type=Path, default=PROGRAM, metavar="FILE", help="lightformer")
    add("--pictures", type=Path, default=ROOT / "out/quality/pictures", metavar="DIR", help="where they are kept")
    return parser.parse_args(arguments)


def print_tables(options: argparse.Namespace) -> None:
    """One of each variation."""
    renderer = Renderer(options.pictures, options.program)
    for chosen in options.seeds:
        shots = methods.references(variation(options.scene, chosen, SIZE), options.spp)
        truth = Truth(*(renderer.picture(shot) for shot in shots))
        title = f"{options.scene.stem}, variation {chosen}"
        print(f"\n{tables.text([judge(encode(renderer, options.scene, chosen), truth, title)])}", flush=True)


def main() -> int:
    """The command."""
    options = parse(sys.argv[1:])
    return finish(lambda: print_tables(options))


if __name__ == "__main__":
    sys.exit(main())
