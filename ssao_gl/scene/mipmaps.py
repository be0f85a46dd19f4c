"""Smaller copies of textures of any size, each texel the mean light of those that it stands for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from . import srgb

F32 = NDArray[np.float32]
CHUNK = 1 << 22
"""Texels averaged at a time."""


def smaller_copies(texels: NDArray[np.uint8]) -> Iterator[NDArray[np.uint8]]:
    """Yield (h // 2, w // 2, 3 or 4) of texels (h, w, 3 or 4) sRGB with linear alpha, and so on down to (1, 1).

    Of odd sizes three texels share two places, by how much of each lies there (Guthe and Heckbert, "Non-power-of-two
    mipmap creation", NVIDIA 2005). A driver may leave some out instead.
    """
    linear = np.concatenate([srgb.decode(np.arange(256) / 255), np.arange(256) / 255]).astype(np.float32)
    while max(texels.shape[:2]) > 1:
        h, w = texels.shape[:2]
        rows = max(CHUNK // w // 2 * 2, 2)
        # In strips only where each gives whole rows.
        strips = [texels[top : top + rows] for top in range(0, h, rows)] if h % 2 == 0 else [texels]
        texels = np.concatenate([_encoded(_halved(_halved(_decoded(strip, linear), 0), 1)) for strip in strips])
        yield texels


def _decoded(texels: NDArray[np.uint8], linear: F32) -> F32:
    light = linear[texels]
    if texels.shape[2] == 4:
        light[..., 3] = linear[256 + texels[..., 3].astype(np.int64)]
    return light


def _encoded(light: F32) -> NDArray[np.uint8]:
    out = np.empty(light.shape, np.uint8)
    out[..., :3] = np.round(srgb.encode(light[..., :3]) * 255)
    out[..., 3:] = np.round(light[..., 3:] * 255)
    return out


def _halved(light: F32, axis: int) -> F32:
    """Return half as many rows (axis 0) or columns (axis 1); one stays one."""
    n = light.shape[axis]
    half = n // 2
    if half == 0:
        return light
    light = np.moveaxis(light, axis, 0)
    if n % 2 == 0:
        halved: F32 = (light[0::2] + light[1::2]) * np.float32(0.5)
    else:
        first = (np.arange(half, 0, -1, dtype=np.float32)).reshape(-1, *[1] * (light.ndim - 1))
        last = (half + 1) - first
        halved = (first * light[0:-1:2] + np.float32(half) * light[1::2] + last * light[2::2]) / np.float32(n)
    return np.moveaxis(halved, 0, axis)
