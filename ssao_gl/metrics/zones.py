"""Where in a view an error is: at depth edges, at creases, or on flat ground.

The zones are those of the truth's own depth and normals, so they are the same for everything that is measured in a view.

edge: within :data:`EDGE_BAND` pixels of a pixel beside a depth edge. Two neighbours lie on either side of one when their
depth differs by more than :data:`STEP` radii, and by as much from what the tangent plane of either says: a floor seen at a
small angle is no edge. So do a pixel of the surface and one of the background.
crease: else, within :data:`CREASE_BAND` pixels of one whose normal turns by more than :data:`TURN` to a neighbour.
flat: the rest of the foreground.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError
from ..scene.projection import ViewConstants

F64 = NDArray[np.float64]
Mask = NDArray[np.bool_]

STEP = 0.25
"""A depth edge: by so many radii of the occlusion."""

TURN = math.radians(20)
"""A crease: normals of neighbours differ by this angle."""

EDGE_BAND, CREASE_BAND = 3, 2
"""Half widths of the bands, pixels."""

ZONES = ("edge", "crease", "flat")


@dataclass(frozen=True, eq=False, slots=True)
class Zones:
    """Masks (h, w) bool, row 0 on top, of which each pixel of the foreground is in one."""

    edge: Mask
    crease: Mask
    flat: Mask

    @property
    def seen(self) -> Mask:
        """(h, w), the foreground."""
        return self.edge | self.crease | self.flat

    def shares(self) -> dict[str, float]:
        """Zone -> its share of the foreground's pixels; nan where there are none."""
        seen = int(self.seen.sum())
        return {name: int(getattr(self, name).sum()) / seen if seen else float("nan") for name in ZONES}


def zones_of(depth: ArrayLike, normals: ArrayLike, view: ViewConstants, radius: float, seen: ArrayLike | None = None) -> Zones:
    """Split a view into zones by its true depth (h, w) and normals (h, w, 3), unit, in view space.

    depth: along the view axis in scene units, 0 = background. radius: of the occlusion, scene units. seen: (h, w), the pixels
    that count, if not all of the surface. Raises FormatError for shapes that do not fit.
    """
    z, n = np.asarray(depth, np.float64), np.asarray(normals, np.float64)
    if z.shape != view.size[::-1] or n.shape != (*z.shape, 3):
        raise FormatError(f"zones: depth {z.shape} and normals {n.shape} must be (h, w) and (h, w, 3) of {view.size[::-1]}")
    surface = np.isfinite(z) & (z > 0)
    z = np.where(surface, z, 0.0)
    points, rays = view.points(z), view.points(np.ones_like(z)) - view.points(np.zeros_like(z))
    edge, crease = np.zeros(z.shape, bool), np.zeros(z.shape, bool)
    for a, b in _neighbours():
        both = surface[a] & surface[b]
        step = np.abs(z[a] - z[b])
        for one, other in ((a, b), (b, a)):
            step = np.minimum(step, _off_plane(points[one], n[one], points[other], rays[other]))
        at_edge = np.where(both, step > STEP * radius, surface[a] ^ surface[b])
        at_crease = both & ((n[a] * n[b]).sum(-1) < math.cos(TURN))
        for mask, found in ((edge, at_edge), (crease, at_crease)):
            mask[a] |= found
            mask[b] |= found
    counted = surface if seen is None else surface & np.asarray(seen, bool)
    edge, crease = dilated(edge, EDGE_BAND), dilated(crease, CREASE_BAND)
    return Zones(counted & edge, counted & crease & ~edge, counted & ~crease & ~edge)


def dilated(mask: Mask, width: int) -> Mask:
    """Every pixel within ``width`` of a set one, along x and along y (a square)."""
    for axis in (0, 1):
        grown = mask.copy()
        for step in range(1, min(width, mask.shape[axis] - 1) + 1):
            a, b, out = (np.moveaxis(m, axis, 0) for m in (mask, mask, grown))
            out[step:] |= a[:-step]
            out[:-step] |= b[step:]
        mask = grown
    return mask


def _neighbours() -> Iterator[tuple[Any, Any]]:
    """Yield what pairs each pixel of an image with the next along y, and along x."""
    before, after, every = slice(None, -1), slice(1, None), slice(None)
    yield (before, every), (after, every)
    yield (every, before), (every, after)


def _off_plane(point: F64, normal: F64, other: F64, ray: F64) -> F64:
    """Return how far, along the view axis, ``other`` lies from the plane through ``point``, measured along its own ray."""
    height = np.abs((normal * (other - point)).sum(-1))
    return np.asarray(height / np.maximum(np.abs((normal * ray).sum(-1)), 1e-12))
