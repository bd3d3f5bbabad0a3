"""The family `lean`: what rays know is not learned, and each pixel stands alone.

    direct       T_l = sum s_k (D_k + G_k),  T_d = sum s_k (V_k,d D_k + V_k,g G_k): closed forms and rays alone
    indirect     a small MLP on what the pixel is and what its rays met:
                 albedo * (factor * bounce + factor * gathered + residue)
                 + (F0 + b) * ((radiance + factor * bounce) * part of the lobe that meets something + gated mirror clue)

It sees neither a direction nor a length: radiances are in units of the picture's own, distances relative to that of the
eye. So it does the same in a scene that is turned, moved or scaled, or that has something far away. Of a light it keeps
nothing but clues, which sum up over lights before the MLP.
"""

from dataclasses import dataclass

from .builder import Builder
from .program import Operation

PARTS = {
    "reached": "rays to spread points of the light, and of highlights (without: unshadowed)",
    "bounce": "unshadowed light of the RSM's texels",
    "gathered": "rays over the hemisphere",
    "surroundings": "what these rays meet: its albedo, and how many meet nothing",
    "mirror": "rays of reflections",
}

# Of the cosine between normal and eye. Below 0, where a normal map turns away, indirect light is 0, as in the reference.
SIDE = 50.0


@dataclass(frozen=True)
class Widths:
    """Channels."""

    decoder: tuple[int, ...] = (32, 32)


def build(widths: Widths, without: frozenset[str]) -> list[Operation]:
    """The program."""
    b = Builder()
    sums = _direct(b, without)
    sums["indirect"] = _indirect(b, widths, without, sums["direct"])
    for name, value in sums.items():
        b.apply("mul", value, "frame.radiance", out=name)
    return b.operations


def _direct(b: Builder, without: frozenset[str]) -> dict[str, str]:
    lobes = "view.diffuse", "view.glossy"
    reached = lobes
    if "reached" not in without:
        reached = [b.apply("mul", lobe, f"{lobe}_reached") for lobe in lobes]
    return {
        name: b.apply("sum", b.apply("add", *parts), "light.share")
        for name, parts in (("unshadowed", lobes), ("direct", reached))
    }


def _indirect(b: Builder, widths: Widths, without: frozenset[str], direct: str) -> str:
    """T_i in units of frame.radiance."""
    cosine = b.apply("dot", "pixel.normal", "pixel.view")
    radiances, features = [direct], [cosine, "pixel.roughness", "pixel.diffuse", "pixel.specular"]
    arriving = []  # diffuse clues; outputs of the decoder that weigh them; factors to begin with, as softplus has them
    if "bounce" not in without:
        bounce = b.apply("sum", "view.bounce", "light.share")
        radiances.append(bounce)
        arriving.append((bounce, 0, -2.0 if "gathered" not in without else 1.2))
    if "gathered" not in without:
        radiances.append("pixel.gathered")
        arriving.append(("pixel.gathered", 3, 0.4))
        if "surroundings" not in without:
            features += ["pixel.gathered_albedo", "pixel.gathered_missed"]
    if "mirror" not in without:
        radiances.append("pixel.mirror_light")
        features += ["pixel.mirror", "pixel.mirror_missed", "pixel.mirror_albedo"]
    logs = b.apply("concat", *(b.apply("log1p", x) for x in radiances))
    decoded = b.mlp("decoder", [*features, logs], list(widths.decoder))
    raw = b.linear("decoded", [decoded], 15, act="none")

    def part(first: int, last: int) -> str:
        return b.apply("slice", raw, **{"from": first, "to": last})

    diffuse = b.apply("softplus", b.affine(part(6, 9), 1.0, -4.0))
    for light, first, bias in arriving:
        factor = b.apply("softplus", b.affine(part(first, first + 3), 1.0, bias))
        diffuse = b.apply("add", b.apply("mul", light, factor), diffuse)
    diffuse = b.apply("mul", diffuse, "pixel.diffuse")
    radiance = b.apply("softplus", b.affine(part(9, 12), 1.0, -3.0))
    if "bounce" not in without:  # rough metals reflect what a diffuse surface would gather
        radiance = b.apply("add", radiance, b.apply("mul", bounce, b.apply("softplus", part(12, 13))))
    if "mirror" not in without:
        # Whatever else is not known: no light comes from where rays meet nothing.
        radiance = b.apply("mul", radiance, b.affine("pixel.mirror_missed", -1.0, 1.0))
        gate = b.apply("sigmoid", b.affine(part(13, 14), 1.0, 2.0))
        radiance = b.apply("add", radiance, b.apply("mul", "pixel.mirror_light", gate))
    fresnel = b.apply("softplus", b.affine(part(14, 15), 1.0, -4.0))
    glossy = b.apply("mul", b.apply("add", "pixel.specular", fresnel), radiance)
    facing = b.apply("clamp", b.affine(cosine, SIDE), low=0.0, high=1.0)
    return b.apply("mul", b.apply("add", diffuse, glossy), facing)
