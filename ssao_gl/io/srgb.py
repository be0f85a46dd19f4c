"""sRGB (IEC 61966-2-1): encoding, decoding, and colour dimmed in linear light."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError


def encode(linear: ArrayLike) -> NDArray[np.float64]:
    """Return linear light in 0..1 (any shape) as sRGB values in 0..1; what lies outside is clamped."""
    x = np.clip(np.asarray(linear, np.float64), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def decode(encoded: ArrayLike) -> NDArray[np.float64]:
    """Return sRGB values in 0..1 (any shape) as linear light in 0..1."""
    c = np.asarray(encoded, np.float64)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def encoded_rgb(linear: ArrayLike) -> tuple[float, float, float]:
    """Return a linear colour (3,) as sRGB (r, g, b) in 0..1."""
    r, g, b = (float(part) for part in encode(linear))
    return r, g, b


def multiply(color: ArrayLike, visibility: ArrayLike) -> NDArray[np.uint8]:
    """Return sRGB colour (h, w, 3 or 4) uint8 times visibility (h, w), in linear light; alpha stays. No OpenGL needed.

    Raises FormatError for shapes and types that do not fit.
    """
    rgb: NDArray[Any] = np.asarray(color)
    factor = np.asarray(visibility, np.float64)
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[:2] != factor.shape:
        raise FormatError(f"multiply: color {rgb.dtype} {rgb.shape} and visibility {factor.shape} do not fit")
    out = rgb.copy()
    out[..., :3] = np.round(encode(decode(rgb[..., :3] / 255.0) * np.clip(factor, 0, 1)[..., None]) * 255)
    return out
