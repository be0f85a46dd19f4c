"""Shadows of a directional light by rays: what of a picture it reaches, and where the edges of the shadows are."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .blockers import DIAMETER, OFFSET, threads
from .sums import blocks
from .surface import Surface

RAYS_TOGETHER = 1 << 15
AROUND = 16
"""Rays around a pixel's own by which edges are found."""


@dataclass(frozen=True, eq=False)
class ShadowTruth:
    """What a light reaches, row 0 on top. lit: (h, w) bool, False on background and on what faces away. edge: (h, w) bool, where
    the shadow's edge is nearer than was asked."""

    lit: NDArray[np.bool_]
    edge: NDArray[np.bool_]


def shadows(seen: Surface, to_light: ArrayLike, reach: ArrayLike) -> ShadowTruth:
    """Trace a ray from every covered pixel to a light.

    to_light: (3,) unit, world. reach: (2, 3) half axes of an ellipse across the light, scene units: a pixel is at an edge where a ray
    that is moved inside it, along the plane of the surface, fares otherwise.
    """
    to = np.asarray(to_light, np.float64)
    axes = np.asarray(reach, np.float64) * seen.rays.scale
    angles = 2 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
    moves = [np.zeros(3), *(share * (np.cos(a) * axes[0] + np.sin(a) * axes[1]) for share in (1.0, 0.5) for a in angles)]
    facing = seen.normals @ to
    front = np.flatnonzero(facing > 0)
    lit, edge = np.zeros(len(facing), bool), np.zeros(len(facing), bool)

    def part(at: slice) -> None:
        these = front[at]
        found = [_reached(seen, these, move, to) for move in moves]
        lit[these] = found[0]
        edge[these] = np.any([other != found[0] for other in found[1:]], axis=0)

    with ThreadPoolExecutor(threads()) as pool:
        list(pool.map(part, blocks(len(front), RAYS_TOGETHER)))
    return ShadowTruth(seen.image(lit, 0) > 0, seen.image(edge, 0) > 0)


def _reached(seen: Surface, these: NDArray[np.intp], move: NDArray[np.float64], to: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which points the light reaches when they are moved along their planes by what looks like ``move`` to it."""
    normals = seen.normals[these].astype(np.float64)
    along = (normals @ move) / np.maximum(normals @ to, 1e-3)
    origins = seen.origins[these] + move - along[:, None] * to + OFFSET * normals
    directions = np.broadcast_to(to.astype(np.float32), origins.shape)
    return seen.rays.occluded(origins.astype(np.float32), directions, DIAMETER) < 0.5
