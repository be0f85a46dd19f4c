"""What most methods have in common: how far they look, and the noise that turns them from pixel to pixel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..settings import setting
from .disk import bayer

TILE = 4
"""Width of the noise tiles, in pixels: what the default filter averages away."""


def radius() -> Any:
    """Return the field ``radius: float | None``, in scene units."""
    return setting(None, "reach of occlusion; none: from the camera or the scene", unit="scene units", above=0)


def max_radius() -> Any:
    """Return the field ``max_radius: float``, in pixels: the largest footprint that taps are meant to cover."""
    return setting(256.0, "largest footprint; nearer surfaces get a smaller reach", unit="pixels", low=1, high=4096)


def reach_uniforms(radius: float | None, max_radius: float) -> Mapping[str, Any]:
    """Return the uniforms of ``lib/taps.glsl``. Raises SettingsError when the radius is not settled."""
    if radius is None:
        raise SettingsError("the radius must be settled before the draw")
    return {"u_radius": radius, "u_max_radius": max_radius, "u_noise_width": float(TILE)}


def tile_directions(span: float) -> NDArray[np.float32]:
    """(TILE, TILE, 4) float32: (cos, sin) of an angle in 0..span radians, a place in 0..1 between two steps, and 0.

    Both are stratified over the tile, in orders that set neighbours, and each other, apart.
    """
    order = bayer(TILE).reshape(TILE, TILE)
    angle = (order + 0.5) / TILE**2 * span
    place = (order * 7 % TILE**2 + 0.5) / TILE**2
    return np.stack([np.cos(angle), np.sin(angle), place, np.zeros_like(place)], -1).astype(np.float32)
