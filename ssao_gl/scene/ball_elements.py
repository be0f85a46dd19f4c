"""The spheres that a scene hides pixels by: its own, and one for each patch of its triangles. And how much drawing them fills."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .bounds import similarity_scale
from .camera import Camera
from .model import Scene
from .prisms import LOOKED_AT, placed_triangles, shares, texel_reach
from .projection import Size, ViewConstants
from .spheres import Spheres
from .surface_patches import AREA, EQUILATERAL, cut_triangles, joined, one_way, patches_of

F64 = NDArray[np.float64]
MOST_PIECES = 1_000_000
"""Pieces of triangles, about, for which patches are made wider."""
MORE = 16
"""Times as many are cut at most, where triangles are long and thin."""
TOO_MANY = (
    "spheres: the scene has too many long and thin triangles to be cut into patches; take a larger radius, or another method"
)
BESIDE = np.array([0.377, 0.619, 0.137])
"""Where the grid of cells begins, in cells: not in the middle of the scene, where rounding would decide for what lies on it."""
CORNERS = np.array([[corner & 4, corner & 2, corner & 1] for corner in range(8)], bool) * 2.0 - 1
"""Of a box about 0, by the bits of a corner's number, as of :func:`.prisms.shares`."""


def ball_elements(scene: Scene, patch: float) -> Iterator[F64]:
    """Yield spheres (n, 7) of a scene, every instance: centre, about the middle of its bounds, radius, and which way it faces.

    A patch, about ``patch`` scene units wide, is a sphere of its area (``pi r^2``) that is seen as much as its normal faces the
    viewer, from either side (what lies in one cell of a grid is one, and loses up to a tenth of its area to the next cells); spheres of the scene's own face all ways: (0, 0, 0). In scenes too large patches are wider. Raises SceneError.
    """
    for balls in _own_spheres(scene):
        yield np.column_stack([balls, np.zeros((len(balls), 3))])
    patches = _patches(scene, patch)
    yield np.column_stack([patches[:, :3], np.sqrt(patches[:, AREA] / np.pi), patches[:, 3:6]])


def _own_spheres(scene: Scene) -> Iterator[F64]:
    """Yield the spheres (n, 4) of each instance that have a size: centre and radius."""
    middle = scene.bounds.mean(0)
    for thing in (thing for thing in scene.drawn if isinstance(thing, Spheres)):
        sized = thing.radii > 0
        for matrix in thing.transforms:
            centers = thing.centers[sized].astype(np.float64) @ matrix[:3, :3].T + (matrix[:3, 3] - middle)
            yield np.column_stack([centers, thing.radii[sized].astype(np.float64) * similarity_scale(matrix)])


def _patches(scene: Scene, width: float) -> F64:
    """Return the patches (m, 7) of all triangles: those of a cell of the grid that face along one axis are one."""
    width = _patch_width(scene, width, 1)
    found = [np.zeros((0, 7))]
    for corners, solid, _ in placed_triangles(scene):
        patches, owner = _cut(corners, width, MOST_PIECES)
        patches[:, AREA] *= solid[owner]
        patches[:, :3] += BESIDE * width
        found.append(joined(one_way(patches), width))
    patches = joined(np.concatenate(found), width)
    patches[:, :3] -= BESIDE * width
    return patches


def _patch_width(scene: Scene, width: float, every: int) -> float:
    """Return the width of patches, of which there are not too many, by the area of each ``every`` th triangle."""
    area = 0.0
    for corners, solid, each in placed_triangles(scene, every):
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area += each * float(np.linalg.norm(across, axis=1) @ solid) / 2
    return max(width, float(np.sqrt(2 * area / (EQUILATERAL * MOST_PIECES))))


def _cut(corners: F64, width: float, about: int) -> tuple[F64, NDArray[np.int32]]:
    """Return patches (m, 7) of triangles (n, 3, 3) whose edges are ``width`` at most, and the triangle (m,) of each."""
    pieces, owner = cut_triangles(corners, np.arange(len(corners), dtype=np.int32), width, MORE * about, TOO_MANY)
    patches, some = patches_of(pieces)
    return patches, owner[some]


def ball_fill(scene: Scene, camera: Camera, view: ViewConstants, size: Size, radius: float, patch: float) -> tuple[int, float]:
    """Return how many spheres a scene has, about, and how many fragments the boxes around them fill in a target of ``size`` texels.

    Patches are counted by their area, in pieces as wide as two radii of some of the triangles.
    """
    from_middle = np.linalg.inv(camera.pose)
    from_middle[:3, 3] += from_middle[:3, :3] @ scene.bounds.mean(0)
    count, total = 0.0, 0.0
    for balls, each in _some_balls(scene, radius, patch):
        seen = balls[:, :3] @ from_middle[:3, :3].T + from_middle[:3, 3]
        half = balls[:, 3] + radius
        half += texel_reach(half - seen[:, 2], view, size)
        count += float(each.sum())
        total += float(each @ shares(seen[:, None] + half[:, None, None] * CORNERS, view)) if len(balls) else 0.0
    return round(count), total * size[0] * size[1]


def _some_balls(scene: Scene, radius: float, patch: float) -> Iterator[tuple[F64, F64]]:
    """Yield some spheres (n, 4) of a scene, and for how many each (n,) stands."""
    every = max(1, sum(len(thing.centers) * len(thing.transforms) for thing in scene.spheres) // LOOKED_AT)
    for balls in _own_spheres(scene):
        some = balls[:: min(every, max(len(balls), 1))]
        yield some, np.full(len(some), len(balls) / max(len(some), 1))
    every = max(1, scene.triangles // LOOKED_AT)
    width = _patch_width(scene, patch, every)
    wide = max(2 * radius, width * np.sqrt(MOST_PIECES / LOOKED_AT))
    for corners, solid, each in placed_triangles(scene, every):
        patches, owner = _cut(corners, wide, LOOKED_AT)
        balls = np.column_stack([patches[:, :3], np.full(len(patches), width / np.sqrt(np.pi))])
        yield balls, each * solid[owner] * patches[:, AREA] / width**2
