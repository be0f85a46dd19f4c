"""Cameras, and the constants by which a shader turns pixels and linear depth into points.

Conventions, for the whole package: right-handed view space with the eye at 0, x right, y up, looking along -z.
``pose`` is camera-to-world (OpenGL, glTF, pyrender, trimesh). Linear depth is ``z = -z_view > 0`` in scene
units; 0 means background. Texture coordinates ``uv`` run from (0, 0) at the lower left to (1, 1).
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import SettingsError

Matrix = NDArray[np.float64]
Size = tuple[int, int]
"""(width, height) in pixels."""

ClipRange = Literal["-1..1", "0..1"]


class Lens(Hashable, Protocol):
    """Anything that gives a projection matrix for an image size."""

    def matrix(self, size: Size) -> Matrix:
        """The (4, 4) projection from view space to clip space, row-major (``clip = matrix @ view``)."""
        ...


@dataclass(frozen=True, slots=True)
class Perspective:
    """Symmetric perspective: vertical field of view in radians, near and far distance (``zfar=None``: infinite)."""

    yfov: float
    znear: float
    zfar: float | None = None

    def __post_init__(self) -> None:
        if not 0 < self.yfov < math.pi:
            raise SettingsError(f"camera: yfov is {self.yfov:g} radians; it must lie between 0 and pi")
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
    """The camera-to-world pose (4, 4) of a camera at ``eye`` that looks at ``target``; ``up`` is upwards in the image."""
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
        """A symmetric perspective camera; ``yfov`` in radians, ``zfar=None`` for an infinite far plane."""
        return cls(Perspective(yfov, znear, zfar), _pose(pose))

    @classmethod
    def orthographic(cls, height: float, znear: float, zfar: float, pose: ArrayLike | None = None) -> Camera:
        """A parallel projection that shows ``height`` scene units from bottom to top."""
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
        if world_to_camera is not None:
            extrinsic = np.eye(4)
            extrinsic[:3] = np.asarray(world_to_camera, np.float64)[:3]
            pose = np.linalg.inv(extrinsic) @ np.diag([1.0, -1.0, -1.0, 1.0])
        return cls(Pinhole(fx, fy, cx, cy, size[0], size[1], znear, zfar), _pose(pose))

    @classmethod
    def from_matrix(cls, projection: ArrayLike, pose: ArrayLike | None = None, clip: ClipRange = "-1..1") -> Camera:
        """Any projection matrix (4, 4), row-major: off-centre, reversed, infinite, oblique; ``clip`` is its depth range."""
        if clip not in ("-1..1", "0..1"):
            raise SettingsError(f"camera: clip={clip!r}; must be '-1..1' or '0..1'")
        return cls(Projection(_matrix4(projection, "projection"), clip), _pose(pose))

    def view(self, size: Size) -> View:
        """The constants for an image of ``size`` (width, height). Raises SettingsError when the projection is unusable."""
        return _view(self.lens, size)


def _pose(pose: ArrayLike | None) -> Matrix:
    return np.eye(4) if pose is None else _matrix4(pose, "pose")


@dataclass(frozen=True, eq=False)
class View:
    """What shaders need of a projection at one image size. Nothing here assumes a symmetric frustum.

    A pixel at ``uv`` with linear depth ``z`` shows the view-space point with ``z_view = -z`` and
    ``xy = (ray @ uv + ray0) * z + (org @ uv + org0)``; clip w is ``w1 * z + w0``. A world-space offset ``d`` parallel to
    the image moves ``uv`` by ``uv_per_unit @ d / w``. (Solved from the x, y and w rows of the projection.)
    """

    size: Size
    projection: Matrix

    def __post_init__(self) -> None:
        m = self.projection
        scale = np.abs(m[:2, :2]).max()
        if not np.isfinite(m).all() or abs(np.linalg.det(m[:2, :2])) < 1e-12 * scale**2 or not scale:
            raise SettingsError("camera: the projection flattens the image (its upper left 2x2 block is singular)")
        if np.abs(m[3, :2]).max() > 1e-9 * np.abs(m[3]).max():
            raise SettingsError("camera: projections whose w depends on x or y are not supported")
        if m[3, 2] > 0:
            raise SettingsError("camera: the projection looks along +z; ssao_gl's view space looks along -z")

    @property
    def w1(self) -> float:
        return float(-self.projection[3, 2])

    @property
    def w0(self) -> float:
        return float(self.projection[3, 3])

    @property
    def pinhole(self) -> bool:
        """All rays pass through the eye: a perspective camera, however off-centre."""
        m = self.projection
        return self.w0 == 0 and m[0, 3] == 0 and m[1, 3] == 0

    @cached_property
    def constants(self) -> dict[str, Any]:
        """The uniforms of ``lib/view.glsl``; matrices are column-major tuples as OpenGL takes them."""
        m = self.projection
        inverse = np.linalg.inv(m[:2, :2])
        # ndc = 2 uv - 1;  xy = inverse @ (ndc * w - m[:2, 2] * z_view - m[:2, 3])
        ray = 2 * inverse * self.w1
        ray0 = inverse @ (m[:2, 2] - self.w1)
        org = 2 * inverse * self.w0
        org0 = -inverse @ (m[:2, 3] + self.w0)
        return {
            "u_ray": tuple(ray.T.ravel()),
            "u_ray0": tuple(ray0),
            "u_org": tuple(org.T.ravel()),
            "u_org0": tuple(org0),
            "u_w": (self.w1, self.w0),
            "u_uv_per_unit": tuple((0.5 * m[:2, :2]).T.ravel()),
            "u_size": tuple(map(float, self.size)),
            "u_texel": (1 / self.size[0], 1 / self.size[1]),
        }

    @cached_property
    def pixel(self) -> float:
        """Size of a pixel, in scene units, per unit of clip w (the larger of its two sides)."""
        steps = 2 * np.linalg.inv(self.projection[:2, :2]) / np.asarray(self.size)
        return float(np.linalg.norm(steps, axis=0).max())

    @cached_property
    def _planes(self) -> dict[float, float]:
        """Window depth (0 and 1) -> the linear depth it stands for, in the middle of the image."""
        inverse = np.linalg.inv(self.projection)
        ends = {d: inverse @ np.array([0, 0, 2 * d - 1, 1.0]) for d in (0.0, 1.0)}
        # What floats leave of an infinite far plane is a w far below the matrix's own size.
        tiny = 1e-13 * np.abs(inverse[3]).max()
        return {d: float(-p[2] / p[3]) if abs(p[3]) > tiny else math.inf for d, p in ends.items()}

    @property
    def near(self) -> float:
        """Linear depth of the near plane."""
        return min(self._planes.values())

    @property
    def far(self) -> float:
        """Linear depth of the far plane; inf when there is none."""
        return max(self._planes.values())

    @cached_property
    def depth_constants(self) -> dict[str, Any]:
        """Uniforms that turn window depth ``d`` in 0..1 into linear depth: ``z = dot(num, p) / dot(den, p)`` with
        ``p = (uv, d - d_far, 1)``. Expanded about the far plane, where window depth has its precision problem."""
        inverse = np.linalg.inv(self.projection)
        far = max(self._planes, key=lambda d: self._planes[d])
        num, den = -inverse[2], inverse[3]

        def row(r: Matrix) -> tuple[float, ...]:
            # ndc = (2u - 1, 2v - 1, 2d - 1, 1), d = d_far + p.z
            return (2 * r[0], 2 * r[1], 2 * r[2], r[3] - r[0] - r[1] + r[2] * (2 * far - 1))

        scale = max(map(abs, row(den))) or 1.0
        return {
            "u_depth_far": far,
            "u_depth_num": tuple(v / scale for v in row(num)),
            "u_depth_den": tuple(v / scale for v in row(den)),
        }

    def points(self, z: NDArray[Any]) -> NDArray[np.float64]:
        """View-space points (h, w, 3) of a linear-depth image (h, w), row 0 on top. Background (0) gives the eye."""
        h, w = z.shape
        c = self.constants
        u, v = np.meshgrid((np.arange(w) + 0.5) / w, 1 - (np.arange(h) + 0.5) / h)
        uv = np.stack([u, v], -1)

        def affine(matrix: str, offset: str) -> NDArray[np.float64]:
            return np.asarray(uv @ np.reshape(c[matrix], (2, 2)) + np.asarray(c[offset]))

        xy = affine("u_ray", "u_ray0") * z[..., None] + affine("u_org", "u_org0")
        return np.concatenate([xy, -z[..., None].astype(np.float64)], -1)


@lru_cache(maxsize=64)
def _view(lens: Lens, size: Size) -> View:
    """A moving camera keeps its view constants, and with them every uniform that is already set."""
    return View(size, lens.matrix(size))
