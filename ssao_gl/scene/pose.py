"""Where a camera stands: (4, 4) camera-to-world matrices in OpenGL axes (x right, y up, z towards the viewer), and other people's."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingsError
from .projection import Matrix

Axes = Literal["opengl", "opencv"]
"""A camera's own axes: x right, y up, z backwards (OpenGL, Blender, NeRF); or x right, y down, z forwards (OpenCV, COLMAP)."""

TURN = np.diag([1.0, -1.0, -1.0, 1.0])
"""From one kind of axes to the other, either way."""
LEAST_RIGID = 2e-3
"""Largest entry of ``R^T R - 1`` of a rotation: files round."""


def matrix4(values: ArrayLike, what: str) -> Matrix:
    """Return a finite (4, 4) matrix of 64-bit floats. Raises SettingsError."""
    try:
        m = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise SettingsError(f"camera: {what} must be a (4, 4) matrix of numbers") from None
    if m.shape != (4, 4) or not np.isfinite(m).all():
        raise SettingsError(f"camera: {what} must be a finite (4, 4) matrix, got shape {m.shape}")
    return m


def rigid(values: ArrayLike, what: str = "pose") -> Matrix:
    """Return a matrix that only turns and moves, (4, 4) or (3, 4), as (4, 4). Raises SettingsError for any other."""
    try:
        m = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise SettingsError(f"camera: {what} must be a (4, 4) matrix of numbers") from None
    if m.shape == (3, 4):
        m = np.vstack([m, [0, 0, 0, 1]])
    m = matrix4(m, what)
    turn = m[:3, :3]
    if not np.allclose(m[3], (0, 0, 0, 1), rtol=0, atol=1e-6):
        raise SettingsError(f"camera: the last row of {what} must be 0 0 0 1, not {' '.join(f'{v:g}' for v in m[3])}")
    with np.errstate(all="ignore"):
        off, handed = np.abs(turn.T @ turn - np.eye(3)).max(), float(np.linalg.det(turn))
    if not off <= LEAST_RIGID:
        sizes = ", ".join(f"{s:.3g}" for s in np.linalg.svd(turn)[1])
        raise SettingsError(f"camera: {what} must turn and move only; its upper left 3x3 block scales by {sizes}")
    if handed < 0:
        raise SettingsError(f"camera: {what} mirrors (determinant -1); a camera turns and moves only")
    return m


def inverse(pose: Matrix) -> Matrix:
    """Return the inverse of a rigid matrix."""
    m = np.eye(4)
    m[:3, :3] = np.linalg.inv(pose[:3, :3])
    m[:3, 3] = -m[:3, :3] @ pose[:3, 3]
    return m


def pose_of(pose: ArrayLike | None = None, world_to_camera: ArrayLike | None = None, axes: Axes | None = None) -> Matrix:
    """Return a camera-to-world pose in OpenGL axes from it or its inverse, (4, 4) or (3, 4).

    ``axes`` are by default OpenGL's for a pose, OpenCV's for ``world_to_camera``. Raises SettingsError.
    """
    if axes not in (None, "opengl", "opencv"):
        raise SettingsError(f"camera: axes={axes!r}; must be 'opengl' (y up, looking along -z) or 'opencv' (y down, along z)")
    if pose is not None and world_to_camera is not None:
        raise SettingsError("camera: give pose or world_to_camera, which is its inverse, and not both")
    if world_to_camera is not None:
        stands = inverse(rigid(world_to_camera, "world_to_camera"))
        return stands if axes == "opengl" else stands @ TURN
    stands = np.eye(4) if pose is None else rigid(pose)
    return stands @ TURN if axes == "opencv" else stands


def look_at(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0, 1, 0)) -> Matrix:
    """Return the camera-to-world pose (4, 4) of a camera at ``eye`` that looks at ``target``; ``up`` is upwards in the
    image."""
    eye, target, up = (np.asarray(v, np.float64) for v in (eye, target, up))
    if not all(v.shape == (3,) and np.isfinite(v).all() for v in (eye, target, up)):
        raise SettingsError("camera: eye, target and up must each be three finite numbers")
    back = eye - target
    right = np.cross(up, back)
    if not np.linalg.norm(back) > 0:
        raise SettingsError("camera: eye and target are the same point")
    if not np.linalg.norm(right) > 1e-12 * np.linalg.norm(up) * np.linalg.norm(back):
        raise SettingsError("camera: up is parallel to the direction of view; choose another up")
    pose = np.eye(4)
    pose[:3, 2] = back / np.linalg.norm(back)
    pose[:3, 0] = right / np.linalg.norm(right)
    pose[:3, 1] = np.cross(pose[:3, 2], pose[:3, 0])
    pose[:3, 3] = eye
    return pose
