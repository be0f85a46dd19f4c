"""Little scenes for tests, as arrays."""

from __future__ import annotations

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


__all__ = ["ao", "camera", "corner", "look_at", "plane", "quad"]
