"""sRGB (IEC 61966-2-1): encoding and decoding."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def encode(linear: ArrayLike) -> NDArray[np.float64]:
    """Return linear light in 0..1 (any shape) as sRGB values in 0..1; what lies outside is clamped."""
    x = np.clip(np.asarray(linear, np.float64), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, np.where(x < 1, 1.055 * x ** (1 / 2.4) - 0.055, 1.0))  # white stays white


def decode(encoded: ArrayLike) -> NDArray[np.float64]:
    """Return sRGB values in 0..1 (any shape) as linear light in 0..1."""
    c = np.asarray(encoded, np.float64)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def encoded_rgb(linear: ArrayLike) -> tuple[float, float, float]:
    """Return a linear colour (3,) as sRGB (r, g, b) in 0..1."""
    r, g, b = (float(part) for part in encode(linear))
    return r, g, b
