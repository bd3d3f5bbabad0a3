"""The family `structured`: what physics knows is not learned.

Of each light k (unit power; shares weigh the sums over lights, so that all is linear in the powers):

    visibility   a U-Net on the distances of eq. 2 and what rays found, at half resolution, and a small head: V of the
                 diffuse and of the glossy lobe
    direct       T_l = sum s_k (D_k + G_k),  T_d = sum s_k (V_k,d D_k + V_k,g G_k), the clues D and G being exact
    transfer     z_i = mean of an MLP over the texels of the RSM; each pixel's gates (half resolution) weigh it:
                 sum s_k g_k z_i,k
    indirect     a U-Net in screen space on geometry, transfer, direct light and clues, then a decoder at full
                 resolution: albedo * (factor * bounce + factor * gathered + residue)
                 + (F0 + b) * ((radiance + factor * bounce) * part of the lobe that meets something + gated mirror clue)

Lengths are in units of the scene's radius R and positions relative to light or eye, so moving or scaling the whole
scene changes nothing. R itself is absolute: whatever is learned of lengths holds for the ratio of R to the size of what
is lit that the data have. Scenes of other sizes want data with such ratios (train.py --radii draws them). `lean` knows
no lengths.
"""

from dataclasses import dataclass

from .builder import Builder
from .program import Operation

UNIT = 1.0  # radiance in units of frame.radiance, the picture's own, is of order one, as features are

PARTS = {
    "attention": "gates of each pixel on a light's indirect embedding (without: plain weighted mean)",
    "half-vector": "how near the half vector and the mirror direction are to a highlight",
    "reached": "rays to spread points of the light, and of highlights",
    "direction": "the direction to the light, in world axes",
    "shadow-clue": "distances to occluders (eq. 2)",
    "decomposition": "visibility of each light (without: one ratio decoded from the sum)",
    "direct-clue": "unshadowed direct light in closed form (without: predicted)",
    "bounce": "unshadowed light of the RSM's texels",
    "gathered": "rays over the hemisphere",
    "mirror": "rays of reflections",
    "visibility-unet": "neighbours in the visibility (without: each pixel alone)",
    "screen-unet": "neighbours in the indirect light (without: each pixel alone)",
    "albedo": "albedo divided out of the diffuse indirect light",
}


@dataclass(frozen=True)
class Widths:
    """Channels; the defaults are `structured-small`."""

    light: int = 16  # z_d
    texel: tuple[int, ...] = (32, 64)  # MLP of RSM texels
    indirect: int = 32  # z_i
    view: tuple[int, ...] = (24, 32, 48, 48)  # visibility U-Net, levels 1, 2, ...
    clue: int = 8  # z_s at full resolution
    head: int = 16
    screen: tuple[int, ...] = (32, 48, 64, 64)  # indirect U-Net, levels 1, 2, ...
    features: int = 16  # its result at full resolution
    decoder: int = 32


@dataclass
class Pixel:
    """Values of pixels that several parts read."""

    cosine: str  # n.v
    log_distance: str
    mirror: str  # direction of the mirror ray


@dataclass
class Visibility:
    """Features of each light's visibility, and what its logits are before anything is learned."""

    code: str  # level 1
    head: str  # level 0
    diffuse: str  # logit by the distances alone
    glossy: str  # the same of highlights


def build(widths: Widths, without: frozenset[str]) -> list[Operation]:
    """The program."""
    b = Builder()
    pixel = _pixel(b)
    light = _light(b, widths)
    seen = _visibility(b, widths, without, pixel, light)
    unshadowed, arriving = _direct(b, widths, without, light, seen)
    sums = {
        "unshadowed": b.apply("sum", unshadowed, "light.share"),
        "direct": b.apply("sum", arriving, "light.share"),
    }
    if "decomposition" in without:
        sums["direct"] = _one_ratio(b, widths, sums["direct"], sums["unshadowed"])
    transfer = _transfer(b, widths, without, seen.code)
    sums["indirect"] = _indirect(b, widths, without, pixel, sums["direct"], transfer)
    for name, value in sums.items():
        b.apply("mul", value, "frame.radiance", out=name)
    return b.operations


def _pixel(b: Builder) -> Pixel:
    cosine = b.apply("dot", "pixel.normal", "pixel.view")
    twice = b.apply("mul", "pixel.normal", b.affine(cosine, 2.0))
    return Pixel(cosine, _log_length(b, "pixel.distance"), b.apply("sub", twice, "pixel.view"))


def _log_length(b: Builder, x: str) -> str:
    return b.apply("log", b.affine(x, 1.0, 1e-3))


def _light(b: Builder, widths: Widths) -> str:
    """z_d: the light's size and shape from its direct VPLs."""
    offset = b.affine("vpl.offset", 8.0)
    vpl = b.mlp("vpl", [offset, "vpl.normal", "vpl.power"], [32, 32])
    return b.linear("z_d", [b.apply("mean", vpl), "light.kind"], widths.light)


def _visibility(b: Builder, widths: Widths, without: frozenset[str], pixel: Pixel, light: str) -> Visibility:
    facing = b.apply("dot", "pixel.normal", "view.direction")
    log_distance = _log_length(b, "view.distance")
    fine, diffuse = [facing], b.affine(facing, 0.0, 1.0)
    if "shadow-clue" not in without:
        gap = b.apply("sub", "view.distance", "view.occluder")
        ratio = b.apply("div", "view.occluder", b.affine("view.distance", 1.0, 1e-3))
        occluded = b.apply("clamp", b.affine(gap, 1000.0), low=0.0, high=1.0)
        log_gap = b.affine(b.apply("log", b.affine(gap, 1.0, 1e-3)), 1 / 3, 1.5)
        fine += [occluded, log_gap, ratio]
        diffuse = b.affine(occluded, -4.0, 2.0)
    glossy = diffuse
    if "reached" not in without:
        diffuse, glossy = (_logit(b, f"view.{lobe}_reached") for lobe in ("diffuse", "glossy"))
        fine += ["view.diffuse_reached", "view.glossy_reached"]
    fine_value = b.apply("concat", *fine)
    coarse = [b.pool(x) for x in (log_distance, pixel.log_distance, pixel.cosine)]
    if "direction" not in without:
        coarse += [b.pool("view.direction"), b.pool("pixel.normal")]
    start = b.linear("view.in", [b.apply("pack", fine_value), *coarse, light], widths.view[0])
    code = start if "visibility-unet" in without else _unet(b, "view", start, widths.view)
    clue = b.apply("unpack", b.linear("z_s", [code], 4 * widths.clue))
    head = _head(b, widths, without, pixel, [clue, fine_value, log_distance])
    return Visibility(code, head, diffuse, glossy)


def _logit(b: Builder, share: str) -> str:
    """What the sigmoid makes a share of again, within a hundredth."""
    return b.apply("sub", b.apply("log", b.affine(share, 1.0, 0.01)), b.apply("log", b.affine(share, -1.0, 1.01)))


def _head(b: Builder, widths: Widths, without: frozenset[str], pixel: Pixel, inputs: list[str]) -> str:
    inputs = [*inputs, pixel.cosine, "pixel.roughness"]
    if "half-vector" not in without:
        half = b.apply("normalize", b.apply("add", "view.direction", "pixel.view"))
        inputs += [b.apply("dot", "pixel.normal", half), b.apply("dot", "view.direction", pixel.mirror)]
    return b.mlp("head", inputs, [widths.head, widths.head])


def _unet(b: Builder, name: str, x: str, widths: tuple[int, ...]) -> str:
    """Skips are sums; the widths are those of the levels, from the finest."""
    skips = []
    for level, width in enumerate(widths):
        x = b.conv(f"{name}.down{level}", [x if level == 0 else b.pool(x)], width)
        skips.append(x)
    for level in reversed(range(len(widths) - 1)):
        if widths[level] != widths[level + 1]:
            x = b.linear(f"{name}.fit{level}", [x], widths[level], act="none")
        x = b.conv(f"{name}.up{level}", [b.apply("add", b.up(x), skips[level])], widths[level])
    return x


def _direct(b: Builder, widths: Widths, without: frozenset[str], light: str, seen: Visibility) -> tuple[str, str]:
    """Radiance of each light at unit share: unshadowed, and as it arrives (without decomposition: features)."""
    if "direct-clue" in without:
        lobes = _predicted_clue(b, widths, light, seen.head)
    else:
        lobes = "view.diffuse", "view.glossy"
    unshadowed = b.apply("add", *lobes)
    if "decomposition" in without:
        return unshadowed, seen.head
    learned = b.affine(b.linear("visible", [seen.head], 2, act="none"), 2.0)
    visible = b.apply("sigmoid", b.apply("add", learned, b.apply("concat", seen.diffuse, seen.glossy)))
    arriving = [
        b.apply("mul", lobe, b.apply("slice", visible, **{"from": i, "to": i + 1})) for i, lobe in enumerate(lobes)
    ]
    return unshadowed, b.apply("add", *arriving)


def _predicted_clue(b: Builder, widths: Widths, light: str, head: str) -> tuple[str, str]:
    predicted = b.mlp("clue", [head, light], [2 * widths.head, 6], last="softplus")
    lobes = [b.affine(b.apply("slice", predicted, **{"from": i, "to": i + 3}), UNIT) for i in (0, 3)]
    return b.apply("mul", "pixel.diffuse", lobes[0]), b.apply("mul", b.affine("pixel.specular", 1.0, 0.02), lobes[1])


def _one_ratio(b: Builder, widths: Widths, features: str, unshadowed: str) -> str:
    """Direct light by one shadow ratio for all lights."""
    ratio = b.mlp("ratio", [features, "pixel.normal", "pixel.roughness"], [widths.decoder, 3], last="sigmoid")
    return b.apply("mul", unshadowed, ratio)


def _transfer(b: Builder, widths: Widths, without: frozenset[str], code: str) -> list[str]:
    """What the lights' embeddings tell of indirect light, level 1."""
    texel = b.mlp("texel", ["texel.offset", "texel.normal", b.apply("log1p", "texel.flux")], list(widths.texel))
    indirect = b.linear("z_i", [b.apply("mean", texel)], widths.indirect, act="none")
    shadow = b.apply("sum", b.linear("z_s.sum", [code], 16, act="none"), "light.share")
    if "attention" in without:
        return [shadow, b.apply("sum", indirect, "light.share")]
    offset = b.pool(b.apply("mul", "view.direction", "view.distance"))
    inputs = [offset, b.pool("pixel.normal"), code, indirect]
    if "direction" in without:
        inputs = [code, indirect]
    gate = b.mlp("gate", inputs, [widths.indirect, widths.indirect], last="sigmoid")
    return [shadow, b.apply("sum", b.apply("mul", gate, indirect), "light.share")]


def _indirect(
    b: Builder, widths: Widths, without: frozenset[str], pixel: Pixel, direct: str, transfer: list[str]
) -> str:
    """T_i in units of frame.radiance."""
    radiances = [direct]
    arriving = []  # diffuse clues; outputs of the decoder that weigh them; factors to begin with, as softplus has them
    if "bounce" not in without:
        bounce = b.apply("sum", "view.bounce", "light.share")
        radiances.append(bounce)
        arriving.append((bounce, 0, -0.8 if "gathered" not in without else 1.2))
    if "gathered" not in without:
        radiances.append("pixel.gathered")
        arriving.append(("pixel.gathered", 12, 0.3))
    if "mirror" not in without:
        radiances.append("pixel.mirror_light")
    logs = b.apply("concat", *(b.log_radiance(x, UNIT) for x in radiances))
    start = b.linear(
        "screen.in",
        [
            b.apply("pack", b.apply("concat", "pixel.normal", pixel.log_distance)),
            b.pool(b.apply("concat", "pixel.view", pixel.mirror, "pixel.roughness", "pixel.diffuse", logs)),
            *transfer,
        ],
        widths.screen[0],
    )
    if "screen-unet" in without:
        start = b.mlp("screen", [start], [widths.screen[0]] * 2)
    else:
        start = _unet(b, "screen", start, widths.screen)
    features = b.apply("unpack", b.linear("screen.out", [start], 4 * widths.features))
    surface = ["pixel.normal", pixel.cosine, "pixel.roughness", "pixel.specular", pixel.mirror, logs]
    if "mirror" not in without:
        surface.append("pixel.mirror")
    decoded = b.mlp("decoder", [features, *surface], [widths.decoder] * 2)
    raw = b.linear("decoded", [decoded], 15, act="none")

    def part(first: int, last: int) -> str:
        return b.apply("slice", raw, **{"from": first, "to": last})

    diffuse = b.affine(b.apply("softplus", b.affine(part(3, 6), 1.0, -2.0)), UNIT)
    for light, first, bias in arriving:
        factor = b.apply("softplus", b.affine(part(first, first + 3), 1.0, bias))
        diffuse = b.apply("add", b.apply("mul", light, factor), diffuse)
    if "albedo" not in without:
        diffuse = b.apply("mul", diffuse, "pixel.diffuse")
    radiance = b.affine(b.apply("softplus", part(6, 9)), UNIT)
    if "bounce" not in without:  # rough metals reflect what a diffuse surface would gather
        radiance = b.apply("add", radiance, b.apply("mul", bounce, b.apply("softplus", part(11, 12))))
    if "mirror" not in without:
        # Whatever else is not known: no light comes from where rays meet nothing.
        radiance = b.apply("mul", radiance, b.affine("pixel.mirror_missed", -1.0, 1.0))
        gate = b.apply("sigmoid", b.affine(part(9, 10), 1.0, 2.0))
        radiance = b.apply("add", radiance, b.apply("mul", "pixel.mirror_light", gate))
    fresnel = b.apply("softplus", b.affine(part(10, 11), 1.0, -4.0))
    glossy = b.apply("mul", b.apply("add", "pixel.specular", fresnel), radiance)
    return b.apply("add", diffuse, glossy)
