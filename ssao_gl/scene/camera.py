"""Cameras: a lens, which gives a projection for any image size, and a pose.

``pose`` is camera-to-world in OpenGL axes (as in glTF, pyrender and trimesh). See :mod:`ssao_gl.scene.projection` for the conventions.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingsError
from .projection import Matrix, Size, ViewConstants

ClipRange = Literal["-1..1", "0..1"]

NARROWEST = 1e-6
"""Smallest field of view, radians, and smallest distance of one from a straight angle."""


class Lens(Hashable, Protocol):
    """Anything that gives a projection matrix for an image size."""

    def matrix(self, size: Size) -> Matrix:
        """Return the (4, 4) projection from view space to clip space, row-major (``clip = matrix @ view``)."""
        ...


@dataclass(frozen=True, slots=True)
class Perspective:
    """Symmetric perspective: vertical field of view in radians, near and far distance (``zfar=None``: infinite)."""

    yfov: float
    znear: float
    zfar: float | None = None

    def __post_init__(self) -> None:
        if not NARROWEST <= self.yfov <= math.pi - NARROWEST:
            degrees = f"; {self.yfov:g} degrees are math.radians({self.yfov:g})" if math.pi < self.yfov < 180 else ""
            raise SettingsError(
                f"camera: yfov is {self.yfov:g} radians; it must lie between 0 and pi, and not at either{degrees}"
            )
        _check_range(self.znear, self.zfar)

    def matrix(self, size: Size) -> Matrix:
        f = 1 / math.tan(self.yfov / 2)
        return _frustum(f * size[1] / size[0], f, 0.0, 0.0, self.znear, self.zfar)


@dataclass(frozen=True, slots=True)
class Orthographic:
    """Parallel projection of a window ``height`` scene units high; its width follows the image."""

    height: float
    znear: float = 0.0
    zfar: float = 1.0

    def __post_init__(self) -> None:
        if not (self.height > 0 and math.isfinite(self.height)):
            raise SettingsError(f"camera: an orthographic height of {self.height:g}; it must be above 0")
        if not self.zfar > self.znear:
            raise SettingsError(f"camera: zfar={self.zfar:g} must lie behind znear={self.znear:g}")
        if not (math.isfinite(self.znear) and math.isfinite(self.zfar)):
            raise SettingsError("camera: the clip planes of a parallel projection must be finite")

    def matrix(self, size: Size) -> Matrix:
        m = np.eye(4)
        m[0, 0], m[1, 1] = 2 * size[1] / (size[0] * self.height), 2 / self.height
        depth = self.zfar - self.znear
        m[2, 2], m[2, 3] = -2 / depth, -(self.zfar + self.znear) / depth
        return m


@dataclass(frozen=True, slots=True)
class Pinhole:
    """Intrinsics in pixels of a ``width`` x ``height`` image, row 0 on top, as OpenCV and COLMAP give them.

    Pixel centres lie at whole numbers + 0.5. Another image size scales the intrinsics.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    znear: float = 0.01
    zfar: float | None = None

    def __post_init__(self) -> None:
        if not (self.fx > 0 and self.fy > 0 and self.width > 0 and self.height > 0):
            raise SettingsError("camera: fx, fy, width and height of a pinhole camera must be above 0")
        if not all(map(math.isfinite, (self.fx, self.fy, self.cx, self.cy))):
            raise SettingsError("camera: fx, fy, cx and cy of a pinhole camera must be finite")
        _check_range(self.znear, self.zfar)

    def matrix(self, size: Size) -> Matrix:
        w, h = self.width, self.height
        return _frustum(2 * self.fx / w, 2 * self.fy / h, 1 - 2 * self.cx / w, 2 * self.cy / h - 1, self.znear, self.zfar)


@dataclass(frozen=True, slots=True, eq=False)
class Projection:
    """Any projection matrix (4, 4), row-major. ``clip`` is its depth range: "-1..1" (OpenGL) or "0..1"."""

    values: Matrix
    clip: ClipRange = "-1..1"

    def matrix(self, size: Size) -> Matrix:
        m = _matrix4(self.values, "projection")
        if self.clip == "0..1":  # to OpenGL's range, which all the rest speaks
            m = m.copy()
            m[2] = 2 * m[2] - m[3]
        return m


@dataclass(frozen=True, slots=True)
class CropLens:
    """What another lens shows in a part of its image: off-centre, with the same pixels.

    ``whole`` is the size of that image, ``corner`` the pixel of it that is the part's lower left; the part's size is the
    one that :meth:`matrix` is asked for.
    """

    lens: Lens
    whole: Size
    corner: tuple[int, int]

    def matrix(self, size: Size) -> Matrix:
        m = self.lens.matrix(self.whole).copy()
        for axis in (0, 1):  # ndc' = (ndc * whole + whole - 2 corner - size) / size
            whole, low, side = self.whole[axis], self.corner[axis], size[axis]
            m[axis] = whole / side * m[axis] + (whole - 2 * low - side) / side * m[3]
        return m


def _check_range(znear: float, zfar: float | None) -> None:
    if not (znear > 0 and math.isfinite(znear)):
        raise SettingsError(f"camera: znear={znear:g} must be above 0")
    if zfar is not None and not zfar > znear:
        raise SettingsError(f"camera: zfar={zfar:g} must lie behind znear={znear:g}")


def _frustum(sx: float, sy: float, ox: float, oy: float, n: float, f: float | None) -> Matrix:
    m = np.zeros((4, 4))
    m[0, 0], m[1, 1], m[0, 2], m[1, 2], m[3, 2] = sx, sy, ox, oy, -1
    infinite = f is None or math.isinf(f)
    m[2, 2], m[2, 3] = (-1, -2 * n) if infinite or f is None else ((f + n) / (n - f), 2 * f * n / (n - f))
    return m


def _matrix4(values: ArrayLike, what: str) -> Matrix:
    m = np.asarray(values, np.float64)
    if m.shape != (4, 4) or not np.isfinite(m).all():
        raise SettingsError(f"camera: {what} must be a finite (4, 4) matrix, got shape {m.shape}")
    return m


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


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A lens and where it stands: ``pose`` is the (4, 4) camera-to-world matrix in OpenGL axes."""

    lens: Lens
    pose: Matrix = field(default_factory=lambda: np.eye(4))
    name: str = ""
    ao_radius: float | None = None
    """A radius in scene units that suits this view, when its file names one."""

    def __post_init__(self) -> None:
        _matrix4(self.pose, "pose")

    @classmethod
    def perspective(cls, yfov: float, znear: float = 0.01, zfar: float | None = None, pose: ArrayLike | None = None) -> Camera:
        """Return a symmetric perspective camera; ``yfov`` in radians, ``zfar=None`` for an infinite far plane."""
        return cls(Perspective(yfov, znear, zfar), _pose(pose))

    @classmethod
    def orthographic(cls, height: float, znear: float, zfar: float, pose: ArrayLike | None = None) -> Camera:
        """Return a parallel projection that shows ``height`` scene units from bottom to top."""
        return cls(Orthographic(height, znear, zfar), _pose(pose))

    @classmethod
    def pinhole(
        cls,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        size: Size,
        *,
        znear: float = 0.01,
        zfar: float | None = None,
        pose: ArrayLike | None = None,
        world_to_camera: ArrayLike | None = None,
    ) -> Camera:
        """OpenCV or COLMAP intrinsics in pixels of an image of ``size`` (width, height).

        ``pose`` is camera-to-world in OpenGL axes; ``world_to_camera`` is the OpenCV extrinsic matrix (x right, y down,
        z forward), (4, 4) or (3, 4), converted here. Give at most one.
        """
        try:
            w, h = size
        except (TypeError, ValueError):
            raise SettingsError(f"camera: size={size!r}; must be (width, height) of the image in pixels") from None
        if world_to_camera is not None:
            extrinsic = np.eye(4)
            extrinsic[:3] = np.asarray(world_to_camera, np.float64)[:3]
            pose = np.linalg.inv(extrinsic) @ np.diag([1.0, -1.0, -1.0, 1.0])
        return cls(Pinhole(fx, fy, cx, cy, w, h, znear, zfar), _pose(pose))

    @classmethod
    def from_matrix(cls, projection: ArrayLike, pose: ArrayLike | None = None, clip: ClipRange = "-1..1") -> Camera:
        """Any projection matrix (4, 4), row-major: off-centre, reversed, infinite, oblique; ``clip`` is its depth range."""
        if clip not in ("-1..1", "0..1"):
            raise SettingsError(f"camera: clip={clip!r}; must be '-1..1' or '0..1'")
        return cls(Projection(_matrix4(projection, "projection"), clip), _pose(pose))

    def view(self, size: Size) -> ViewConstants:
        """Return the constants for an image of ``size`` (width, height). Raises SettingsError when the projection is
        unusable."""
        return _view(self.lens, size)


def _pose(pose: ArrayLike | None) -> Matrix:
    return np.eye(4) if pose is None else _matrix4(pose, "pose")


@lru_cache(maxsize=64)
def _view(lens: Lens, size: Size) -> ViewConstants:
    """Return the constants of a lens: a moving camera keeps them, and with them every uniform that is already set."""
    return ViewConstants(size, lens.matrix(size), lens.whole if isinstance(lens, CropLens) else None)
