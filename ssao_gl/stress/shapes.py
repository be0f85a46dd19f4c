"""Little scenes, as meshes."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..scene.camera import Camera
from ..scene.model import Mesh, Scene

QUAD = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def lens(zfar: float | None = 40.0, scale: float = 1.0, pose: NDArray[np.float64] | None = None) -> Camera:
    """Return the camera before these scenes: at the origin, looking along -z, in units of ``scale``."""
    return Camera.perspective(0.9, 0.1 * scale, None if zfar is None else zfar * scale, pose)


def quad(center: ArrayLike, u: ArrayLike, v: ArrayLike) -> Mesh:
    """Return a parallelogram: center +- u +- v, flat shaded."""
    c, u_, v_ = (np.asarray(x, np.float64) for x in (center, u, v))
    return Mesh(np.stack([c - u_ - v_, c + u_ - v_, c + u_ + v_, c - u_ + v_]).astype(np.float32), QUAD)


def plane(tilt: float = 0.0, away: float = 5.0) -> Scene:
    """Return a large plane before the camera, tilted about x by ``tilt`` radians."""
    s = 8 * away
    return Scene([quad((0, 0, -away), (s, 0, 0), (0, s * np.cos(tilt), s * np.sin(tilt)))])


def corner() -> Scene:
    """Two large walls that meet at right angles along the y axis, the corner 5 units before the camera."""
    s = 10 / np.sqrt(2)
    return Scene([quad((s, 0, -5 + s), (s, 0, s), (0, 10, 0)), quad((-s, 0, -5 + s), (s, 0, -s), (0, 10, 0))])


def moved(scene: Scene, matrix: NDArray[np.float64]) -> Scene:
    """Return the scene, and its cameras, with every transform preceded by ``matrix`` (4, 4)."""
    draws = [dataclasses.replace(d, transforms=matrix @ d.transforms) for d in scene.meshes]
    poses = [matrix @ c.pose for c in scene.cameras]
    for pose in poses:
        pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)  # cameras have no size
    cameras = [dataclasses.replace(c, pose=pose) for c, pose in zip(scene.cameras, poses, strict=True)]
    return Scene(draws, cameras=cameras, up=scene.up, name=scene.name)


def scaled(scene: Scene, s: float) -> Scene:
    """Return the scene in other units: ``s`` times as large, without cameras."""
    made = moved(scene, np.diag([s, s, s, 1.0]))
    return Scene(made.meshes, up=scene.up, name=scene.name)
