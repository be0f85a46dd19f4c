"""sRGB encoding and decoding, and colour dimmed in linear light."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError


def multiply(color: ArrayLike, visibility: ArrayLike) -> NDArray[np.uint8]:
    """sRGB colour (h, w, 3 or 4) uint8 times visibility (h, w), in linear light; alpha stays. No OpenGL needed."""
    rgb, factor = np.asarray(color), np.asarray(visibility, np.float64)
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[:2] != factor.shape:
        raise FormatError(f"multiply: color {rgb.dtype} {rgb.shape} and visibility {factor.shape} do not fit")
    c = rgb[..., :3] / 255.0
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) * np.clip(factor, 0, 1)[..., None]
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    out = rgb.copy()
    out[..., :3] = np.round(encoded * 255)
    return out
