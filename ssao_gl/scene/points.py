"""Points as small discs along the surface that they sample (surfels: Pfister et al. 2000), so that depth and normals are whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError

CORNERS = 6
"""Of a disc."""
NEIGHBOURS = 12
"""Points, itself among them, whose plane a disc lies in."""
REACH = 6
"""A disc reaches to so many neighbours: of points at random, one spot in exp(6) = 400 stays open then (Poisson)."""
LARGEST = 3.0
"""Radius of a disc, in medians of all: points by themselves do not become large ones."""
CHUNK = 1 << 16
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Surfels:
    """Hexagons about ``middle`` (3,) float64: positions and normals (6 n, 3), triangles (4 n, 3), colours (6 n, 4) or None."""

    positions: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    normals: NDArray[np.float32]
    colors: NDArray[np.uint8] | None
    middle: Floats


def surfels(
    positions: ArrayLike, colors: ArrayLike | None, radius: float | None, normals: ArrayLike | None, where: str = "points"
) -> Surfels:
    """Return one hexagon a point; see :meth:`ssao_gl.Scene.from_points` for the arguments. Raises SceneError."""
    points = np.asarray(positions, np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise SceneError(f"{where}: positions must be (n, 3), got {points.shape}")
    seen = np.isfinite(points).all(1)
    if not seen.any():
        raise SceneError(f"{where}: none of the {len(points)} positions is finite")
    if radius is not None and not (radius > 0 and np.isfinite(radius)):
        raise SceneError(f"{where}: a radius of {radius:g}; it must be above 0 (scene units)")
    given = None if normals is None else _rows(normals, len(points), (3,), f"{where}: normals")[seen]
    shades = None if colors is None else _rgba(_rows(colors, len(points), (3, 4), f"{where}: colors")[seen])
    points = points[seen]
    middle = (points.min(0) + points.max(0)) / 2
    points -= middle
    if given is None or radius is None:
        reach, found = _neighbourhoods(points)
        given = found if given is None else given
        radii = _sizes(reach) if radius is None else np.full(len(points), radius)
    else:
        radii = np.full(len(points), radius)
    shades = None if shades is None else np.repeat(shades, CORNERS, 0)
    return Surfels(*_discs(points, radii, given), shades, middle)


def _rows(values: ArrayLike, count: int, widths: tuple[int, ...], what: str) -> NDArray[Any]:
    array = np.asarray(values)
    if array.ndim != 2 or len(array) != count or array.shape[1] not in widths:
        raise SceneError(f"{what} must be ({count}, {' or '.join(map(str, widths))}), got {array.shape}")
    return array


def _rgba(colors: NDArray[Any]) -> NDArray[np.uint8]:
    top = 1.0 if colors.dtype.kind == "f" else float(np.iinfo(colors.dtype).max)
    shades = np.full((len(colors), 4), 255, np.uint8)
    shades[:, : colors.shape[1]] = np.round(np.clip(np.nan_to_num(colors / top), 0, 1) * 255)
    return shades


def _neighbourhoods(points: Floats) -> tuple[Floats, Floats]:
    """Distance (n,) to the last of REACH neighbours, and the unit normal (n, 3) of the plane through NEIGHBOURS."""
    from scipy.spatial import cKDTree  # takes a while

    # A tree has no way to part points at one place, and would go through all of them for each of them.
    sums = points @ np.array([0.7548776662, 0.5698402910, 0.4656712318])
    if len(np.unique(sums)) < len(points):
        places, which = np.unique(points, axis=0, return_inverse=True)
        if len(places) < len(points):
            reach, normals = _neighbourhoods(places)
            return reach[which.ravel()], normals[which.ravel()]
    tree = cKDTree(points)
    count = min(NEIGHBOURS, len(points))
    reach, normals = np.zeros(len(points)), np.tile([0.0, 0.0, 1.0], (len(points), 1))
    for start in range(0, len(points), CHUNK):
        part = slice(start, start + CHUNK)
        distances, which = tree.query(points[part], np.arange(1, count + 1))
        reach[part] = distances[:, min(REACH, count - 1)]
        if count > 2:
            around = points[which] - points[which].mean(1, keepdims=True)
            around /= np.maximum(np.abs(around).max((1, 2), keepdims=True), 1e-300)  # squares of tiny ones would vanish
            normals[part] = np.linalg.eigh(around.transpose(0, 2, 1) @ around)[1][:, :, 0]
    return reach, normals


def _sizes(reach: Floats) -> Floats:
    typical = float(np.median(reach[reach > 0])) if (reach > 0).any() else 1.0
    return np.where(reach > 0, np.minimum(reach, LARGEST * typical), typical)


def _discs(
    points: Floats, radii: Floats, normals: Floats
) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.float32]]:
    """Corners (6 n, 3), triangles (4 n, 3) and normals (6 n, 3) of hexagons."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    usable = np.isfinite(length) & (length > 0)
    unit = np.where(usable, np.divide(normals, length, where=usable, out=np.zeros(normals.shape)), [0.0, 0.0, 1.0])
    aside = np.where(np.abs(unit[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    x = np.cross(aside, unit)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(unit, x)
    corners = np.empty((len(points), CORNERS, 3), np.float32)
    for corner in range(CORNERS):
        angle = 2 * np.pi * corner / CORNERS
        corners[:, corner] = points + radii[:, None] * (np.cos(angle) * x + np.sin(angle) * y)
    fan = np.array([[0, k, k + 1] for k in range(1, CORNERS - 1)], np.uint32)
    triangles = (np.arange(len(points), dtype=np.uint32)[:, None, None] * CORNERS + fan).reshape(-1, 3)
    return corners.reshape(-1, 3), triangles, np.repeat(unit.astype(np.float32), CORNERS, 0)
