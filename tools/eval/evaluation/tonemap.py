"""engine/shaders/shared/tonemap.h on arrays; a test compares the two through the PSNR."""

import numpy as np

START, DESATURATION = 0.8 - 0.04, 0.15
MIDDLE_GREY = 0.18


def tonemap(rgb):
    """Khronos PBR Neutral of linear colours [...][3], exposure applied, not negative."""
    toe = rgb.min(axis=-1, keepdims=True)
    offset = np.where(toe < 0.08, toe - 6.25 * toe * toe, 0.04)
    rgb = rgb - offset
    peak = rgb.max(axis=-1, keepdims=True)
    over = np.maximum(peak, START)  # below, nothing is compressed
    span = 1.0 - START
    compressed = 1.0 - span * span / (over + span - START)
    grey = 1.0 - 1.0 / (DESATURATION * (over - compressed) + 1.0)
    scaled = rgb * (compressed / over)
    return np.where(peak < START, rgb, scaled * (1.0 - grey) + compressed * grey)


def srgb_encode(x):
    """Linear 0..1 to sRGB 0..1."""
    x = np.clip(x, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def srgb_decode(x):
    """sRGB 0..1 to linear 0..1."""
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def show(rgb, exposure, display):
    """What a display shows, 0..1: light of a display (a PNG) as it is, radiance exposed and tone-mapped."""
    if display:
        return srgb_encode(rgb)
    return srgb_encode(tonemap(np.maximum(rgb * exposure, 0.0)))
