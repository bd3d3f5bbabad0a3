"""The family `paper`: LightFormer (Ren et al. 2024), sections 4 and 5, with the widths of its supplementary.

Positions are absolute, radiometry is divided by the mean power over the frame's lights and multiplied back at the
output, radiance is decoded as log(1 + x), a softmax over the lights weighs their embeddings. Where the paper is
silent: skips of the U-Net are sums; query and key have as many channels as z_d.
"""

from dataclasses import dataclass

from .builder import Builder
from .program import Operation

# Radiance of a lit room in units of the mean power of a light is about a thirtieth.
UNIT = 1 / 30

PARTS = {
    "attention": "softmax over the lights (without: plain mean)",
    "half-vector": "z_h",
    "direction": "z_l",
    "shadow-clue": "z_s",
    "decomposition": "decoders of their own for unshadowed, shadow and indirect (without: one for all)",
}

HEADS = 8
GBUFFER = ["pixel.position", "pixel.normal", "pixel.diffuse", "pixel.specular", "pixel.roughness"]


@dataclass(frozen=True)
class Widths:
    """Channels; the defaults are the paper's own."""

    direct: tuple[int, ...] = (256, 256, 256, 256, 256)  # VPL encoder; the last is z_d
    indirect: tuple[int, ...] = (64, 64, 64, 128, 512)  # texel encoder; the last is z_i
    specular: tuple[int, ...] = (64, 64, 64, 32)  # z_h and z_l
    view: tuple[int, ...] = (8, 16, 32, 128, 256)  # shadow U-Net, levels 0, 1, ...; the first is z_s
    query: int = 256
    decoder: int = 256
    latent: int = 32  # handed from the direct decoder to the shadow head
    shadow: int = 32


def build(widths: Widths, without: frozenset[str]) -> list[Operation]:
    """The program."""
    b = Builder()
    embedding = {
        "d": _rows(b, "vpl", "vpl.position", "vpl.normal", "vpl.power", widths.direct),
        "i": _rows(b, "texel", "texel.position", "texel.normal", "texel.flux", widths.indirect),
    }
    sizes = {"d": widths.direct[-1], "i": widths.indirect[-1]}
    if "half-vector" not in without:
        half = b.apply("normalize", b.apply("add", "view.direction", "pixel.view"))
        embedding["h"] = b.mlp("z_h", [half, b.apply("dot", "pixel.normal", half)], list(widths.specular))
        sizes["h"] = widths.specular[-1]
    facing = b.apply("dot", "pixel.normal", "view.direction")
    if "direction" not in without:
        log_distance = b.apply("log", b.affine("view.distance", 1.0, 1e-3))
        embedding["l"] = b.mlp("z_l", ["view.direction", facing, log_distance], list(widths.specular))
        sizes["l"] = widths.specular[-1]
    if "shadow-clue" not in without:
        embedding["s"] = _shadow_clue(b, widths, facing)
        sizes["s"] = widths.view[0]
    gathered = _gather(b, widths, embedding, sizes, without)
    _decode(b, widths, gathered, without)
    return b.operations


def _relative_power(b: Builder, share: str) -> str:
    """A light's power by channel in units of the mean power, of what is given per power."""
    power = b.apply("dot", "light.power", b.affine("light.kind", 0.0, 1 / 3))
    mean = b.affine("frame.mean_power", 1.0, 1e-12)
    return b.apply("mul", share, b.apply("div", power, mean))


def _rows(b: Builder, name: str, position: str, normal: str, power: str, widths: tuple[int, ...]) -> str:
    """A light's code from its direct VPLs or its RSM: MLP, then mean."""
    relative = b.apply("log1p", _relative_power(b, power))
    return b.apply("mean", b.mlp(name, [position, normal, relative], list(widths), last="none"), out=f"z_{name}")


def _shadow_clue(b: Builder, widths: Widths, facing: str) -> str:
    """z_s: a U-Net on the seven channels of eq. 2."""
    ratio = b.apply("div", "view.occluder", b.affine("view.distance", 1.0, 1e-3))
    difference = b.apply("sub", "view.occluder", "view.distance")
    eye = b.apply("dot", "pixel.normal", "pixel.view")
    x = b.apply("concat", difference, ratio, facing, eye, "pixel.position")
    skips = []
    for level, width in enumerate(widths.view):
        x = _double(b, f"view.down{level}", x if level == 0 else b.pool(x), width)
        skips.append(x)
    for level in reversed(range(1, len(widths.view) - 1)):
        x = b.up(b.linear(f"view.fit{level}", [x], widths.view[level], act="none"))
        x = _double(b, f"view.up{level}", b.apply("add", x, skips[level]), widths.view[level])
    return b.linear("z_s", [b.up(x), skips[0]], widths.view[0], act="none")


def _double(b: Builder, name: str, x: str, width: int) -> str:
    return b.linear(f"{name}.1", [b.conv(f"{name}.0", [x], width, act="relu")], width, act="relu")


def _gather(
    b: Builder, widths: Widths, embedding: dict[str, str], sizes: dict[str, int], without: frozenset[str]
) -> dict[str, str]:
    """The composed embedding, by its parts (5.1)."""
    if "attention" in without:
        count = b.apply("sum", b.affine("light.share", 0.0, 1.0))
        sums = {part: b.apply("sum", z) for part, z in embedding.items()}
        count = b.apply("max", count, b.affine(count, 0.0, 1.0))
        return {part: b.apply("div", total, count) for part, total in sums.items()}
    query = b.mlp("query", GBUFFER, [widths.query] * 2, last="none")
    key = b.linear("key", [embedding["d"]], widths.query, act="none")
    composed = b.apply("attend", query, key, b.apply("concat", *embedding.values()), heads=HEADS, gate="softmax")
    gathered, first = {}, 0
    for part, size in sizes.items():
        gathered[part] = b.apply("slice", composed, **{"from": first, "to": first + size})
        first += size
    return gathered


def _decode(b: Builder, widths: Widths, z: dict[str, str], without: frozenset[str]) -> None:
    lobes = [z[part] for part in "hl" if part in z]
    shadow = [z["s"]] if "s" in z else []
    if "decomposition" in without:
        raw = _decoder(b, widths, "decoder", [*GBUFFER, z["d"], *lobes, *shadow, z["i"]], 9)
        raws = {"unshadowed": (0, raw), "shadow": (3, raw), "indirect": (6, raw)}
    else:
        direct = _decoder(b, widths, "direct", [*GBUFFER, z["d"], *lobes], 3 + widths.latent)
        latent = b.apply("slice", direct, **{"from": 3, "to": 3 + widths.latent})
        ratio = b.mlp("shadow", [latent, *shadow], [widths.shadow, widths.shadow, 3], last="none")
        indirect = _decoder(b, widths, "indirect.decoder", [*GBUFFER, z["i"]], 3)
        raws = {"unshadowed": (0, direct), "shadow": (0, ratio), "indirect": (0, indirect)}

    def channels(name: str) -> str:
        first, raw = raws[name]
        return b.apply("slice", raw, **{"from": first, "to": first + 3})

    unshadowed = _radiance(b, channels("unshadowed"), "unshadowed")
    ratio = b.affine(b.apply("tanh", channels("shadow")), 0.5, 0.5)
    b.apply("mul", unshadowed, ratio, out="direct")
    _radiance(b, channels("indirect"), "indirect")


def _decoder(b: Builder, widths: Widths, name: str, inputs: list[str], channels: int) -> str:
    """Four layers; the input enters the third again."""
    x = b.mlp(name, inputs, [widths.decoder] * 2)
    x = b.linear(f"{name}.2", [x, *inputs], widths.decoder)
    return b.linear(f"{name}.3", [x], channels, act="none")


def _radiance(b: Builder, raw: str, out: str) -> str:
    """exp(softplus) - 1, in units of the mean power: of log(1 + radiance)."""
    positive = b.affine(b.apply("exp", b.apply("softplus", raw)), UNIT, -UNIT)
    return b.apply("mul", positive, "frame.mean_power", out=out)
