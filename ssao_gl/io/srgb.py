"""Colour dimmed in linear light."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError
from ..scene.srgb import decode, encode


def multiply(color: ArrayLike, visibility: ArrayLike) -> NDArray[np.uint8]:
    """Return sRGB colour (h, w, 3 or 4) uint8 times visibility (h, w), in linear light; alpha stays. No OpenGL needed.

    Raises FormatError for shapes and types that do not fit.
    """
    return dimmed(color, visibility, 1.0)


def dimmed(color: ArrayLike, visibility: ArrayLike, strength: float) -> NDArray[np.uint8]:
    """Return :func:`multiply` for light of which the share ``strength`` in 0..1 is ambient."""
    rgb: NDArray[Any] = np.asarray(color)
    factor = np.asarray(visibility, np.float64)
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[:2] != factor.shape:
        raise FormatError(f"multiply: color {rgb.dtype} {rgb.shape} and visibility {factor.shape} do not fit")
    factor = 1 - strength * (1 - np.clip(factor, 0, 1))
    out = rgb.copy()
    out[..., :3] = np.round(encode(decode(rgb[..., :3] / 255.0) * factor[..., None]) * 255)
    return out
