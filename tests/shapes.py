"""Little scenes for tests, as arrays."""

from __future__ import annotations

import dataclasses

import numpy as np

import ssao_gl as ao
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.pose import look_at

QUAD = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def quad(center: tuple[float, float, float], u: tuple[float, float, float], v: tuple[float, float, float]) -> Mesh:
    """A flat quad: center +- u +- v."""
    c, u_, v_ = (np.asarray(x, np.float64) for x in (center, u, v))
    corners = np.stack([c - u_ - v_, c + u_ - v_, c + u_ + v_, c - u_ + v_])
    normal = np.cross(u_, v_)
    normals = np.broadcast_to(normal / np.linalg.norm(normal), (4, 3)).astype(np.float32)
    return Mesh(corners.astype(np.float32), QUAD, normals)


def plane(tilt: float = 0.0) -> Scene:
    """A large plane, 5 units before a camera at the origin, tilted about x by ``tilt`` radians."""
    return Scene([quad((0, 0, -5), (40, 0, 0), (0, 40 * np.cos(tilt), 40 * np.sin(tilt)))])


def corner() -> Scene:
    """Two large walls that meet at right angles along the y axis, the corner 5 units before a camera at the origin."""
    s = 10 / np.sqrt(2)
    return Scene([quad((s, 0, -5 + s), (s, 0, s), (0, 10, 0)), quad((-s, 0, -5 + s), (s, 0, -s), (0, 10, 0))])


def camera(zfar: float | None = 40.0, pose: np.ndarray | None = None) -> Camera:
    return Camera.perspective(0.9, 0.1, zfar, pose)


def moved(scene: Scene, matrix: np.ndarray) -> Scene:
    """The scene with every transform preceded by ``matrix`` (4, 4)."""
    draws = [dataclasses.replace(d, transforms=matrix @ d.transforms) for d in scene.meshes]
    cameras = [dataclasses.replace(c, pose=matrix @ c.pose) for c in scene.cameras]
    return Scene(draws, cameras=cameras, up=scene.up, name=scene.name)


def scaled(scene: Scene, s: float) -> Scene:
    """The scene in other units: ``s`` times as large. Its cameras are dropped."""
    draws = [dataclasses.replace(d, transforms=np.diag([s, s, s, 1.0]) @ d.transforms) for d in scene.meshes]
    return Scene(draws, up=scene.up, name=scene.name)


def with_radius(method: object, radius: float) -> object:
    """The method with a radius in scene units; those whose radius is something else keep theirs."""
    in_scene_units = next(f for f in dataclasses.fields(method) if f.name == "radius").metadata["limits"].unit == "scene units"  # type: ignore[arg-type]
    return dataclasses.replace(method, radius=radius) if in_scene_units else method  # type: ignore[type-var]


def spread(method: object) -> int:
    """How many times as many pixels of the image change with each that is drawn: what differs in one pixel of a smaller target
    shows in the pixels of its neighbours too, by bilinear weights."""
    return 4 if getattr(method, "scale", 1) > 1 else 1


__all__ = ["ao", "camera", "corner", "look_at", "moved", "plane", "quad", "scaled", "spread", "with_radius"]
