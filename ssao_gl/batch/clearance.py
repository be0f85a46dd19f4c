"""How far an eye is from what a scene draws, and eyes that keep away from it."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ..scene.camera import Camera
from ..scene.lens import Perspective
from ..scene.model import Mesh, Scene
from ..scene.spheres import Spheres

STEP = 1.1
"""Factor by which an eye that is too near moves from or to the middle, again and again."""
MOST_STEPS = 200
F64 = NDArray[np.float64]


def cleared(camera: Camera, scene: Scene, distance: float, keep_away: float) -> Camera:
    """Return an automatic camera at ``distance`` times its own from the scene's middle, moved out or in until it is clear.

    Clear is what is ``keep_away`` times the scene's diagonal from all surfaces. The near plane follows. An eye beyond the
    scene's box and that margin is clear without a look at any triangle.
    """
    center, least = scene.core.mean(0), keep_away * scene.extent
    arm = camera.pose[:3, 3] - center
    factors = (distance * STEP**step for count in range(MOST_STEPS) for step in ((count, -count) if count else (0,)))
    factor = next((one for one in factors if not least or is_clear(scene, center + one * arm, least)), distance)
    if factor == 1:
        return camera
    pose = camera.pose.copy()
    pose[:3, 3] = center + factor * arm
    lens = camera.lens
    if isinstance(lens, Perspective):
        # Aslant, what is that far from the eye is nearer along the axis.
        near = lens.znear if factor > 1 else max(min(lens.znear, 0.3 * least), 1e-4 * scene.extent)
        lens = dataclasses.replace(lens, znear=near, zfar=None if lens.zfar is None else lens.zfar * max(factor, 1.0))
    return dataclasses.replace(camera, pose=pose, lens=lens)


def is_clear(scene: Scene, eye: F64, least: float) -> bool:
    """Whether no surface is nearer than ``least`` to ``eye`` (3,); of volumes their box counts."""
    return _outside(scene.bounds, eye) > least or all(_thing_clear(thing, eye, least) for thing in scene.drawn)


def _thing_clear(thing: object, eye: F64, least: float) -> bool:
    if not isinstance(thing, Mesh | Spheres):
        return _outside(np.asarray(thing.bounds), eye) > least  # type: ignore[attr-defined]
    return all(_placed_clear(thing, matrix, eye, least) for matrix in thing.transforms)


def _placed_clear(thing: Mesh | Spheres, matrix: F64, eye: F64, least: float) -> bool:
    if isinstance(thing, Spheres):
        centers = thing.centers @ matrix[:3, :3].T + matrix[:3, 3]
        radii = thing.radii * np.linalg.norm(matrix[:3, 0])
        return bool((np.abs(np.linalg.norm(centers - eye, axis=1) - radii) > least).all())
    points = thing.positions @ matrix[:3, :3].T.astype(np.float32) + matrix[:3, 3].astype(np.float32)
    corners = points[thing.triangles]
    near = ((corners.min(1) < eye + least) & (corners.max(1) > eye - least)).all(1)
    return not near.any() or float(triangle_distances(corners[near].astype(np.float64), eye).min()) > least


def _outside(box: F64, point: F64) -> float:
    """Return how far a point is from a box; 0 within."""
    return float(np.linalg.norm(np.maximum(np.maximum(box[0] - point, point - box[1]), 0)))


def triangle_distances(corners: F64, point: F64) -> F64:
    """Return the distances (n,) of a point (3,) from triangles (n, 3, 3).

    The nearest place is above the face, or else on one of the three edges.
    """
    edges = np.roll(corners, -1, axis=1) - corners
    to = point - corners
    lengths = np.maximum((edges**2).sum(2), 1e-300)
    share = np.clip((to * edges).sum(2) / lengths, 0, 1)
    on_edges = np.linalg.norm(to - share[..., None] * edges, axis=2).min(1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    size = np.linalg.norm(normal, axis=1)
    inside = ((np.cross(edges, to) * normal[:, None]).sum(2) >= 0).all(1) & (size > 0)
    above = np.abs((to[:, 0] * normal).sum(1)) / np.maximum(size, 1e-300)
    distances: F64 = np.where(inside, above, on_edges)
    return distances
