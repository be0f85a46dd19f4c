"""Lenses: what gives a projection for any image size, and how camera files write them."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingsError
from .pose import matrix4
from .projection import Matrix, Size

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
        m = matrix4(self.values, "projection")
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


@dataclass(frozen=True, slots=True)
class ShiftedLens:
    """What another lens shows, moved by ``shift`` pixels to the right and upwards."""

    lens: Lens
    shift: tuple[float, float]

    def matrix(self, size: Size) -> Matrix:
        m = self.lens.matrix(size).copy()
        for axis in (0, 1):
            m[axis] += 2 * self.shift[axis] / size[axis] * m[3]
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


def intrinsics_of(k: ArrayLike) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy of a calibration matrix (3, 3) without skew. Raises SettingsError."""
    try:
        m = np.asarray(k, np.float64)
    except (TypeError, ValueError):
        m = np.zeros(0)
    if m.shape != (3, 3) or not np.isfinite(m).all():
        raise SettingsError(f"camera: intrinsics must be a finite (3, 3) matrix, got shape {m.shape}")
    if not np.allclose(m[[1, 2, 2, 2], [0, 0, 1, 2]], (0, 0, 0, 1), rtol=0, atol=1e-9 * np.abs(m).max()):
        raise SettingsError("camera: intrinsics must look like fx 0 cx, 0 fy cy, 0 0 1; is the matrix transposed?")
    if abs(m[0, 1]) > 1e-3 * abs(m[0, 0]):
        raise SettingsError(f"camera: intrinsics with skew ({m[0, 1]:g}) are not supported")
    return float(m[0, 0]), float(m[1, 1]), float(m[0, 2]), float(m[1, 2])


def lens_table(lens: Lens) -> dict[str, Any]:
    """Return a lens as camera files write it. Raises SettingsError for one of another package."""
    match lens:
        case Perspective():
            return {"yfov_deg": math.degrees(lens.yfov), "znear": lens.znear, "zfar": lens.zfar}
        case Orthographic():
            return {"ortho_height": lens.height, "znear": lens.znear, "zfar": lens.zfar}
        case Pinhole():
            k = {name: getattr(lens, name) for name in ("fx", "fy", "cx", "cy", "width", "height")}
            return {"intrinsics": k, "znear": lens.znear, "zfar": lens.zfar}
        case Projection():
            return {"projection": np.asarray(lens.values, np.float64).tolist(), "clip": lens.clip}
    raise SettingsError(f"camera: a {type(lens).__name__} cannot be written; its projection can: Camera.from_matrix")


def lens_of(table: Mapping[str, Any]) -> Lens:
    """Return the lens of an entry of a camera file, whose angle is in degrees. Raises KeyError, TypeError, ValueError, SettingsError."""
    znear = float(table.get("znear", 0.01))
    zfar = None if table.get("zfar") is None else float(table["zfar"])
    if "projection" in table:
        if table.get("clip", "-1..1") not in ("-1..1", "0..1"):
            raise SettingsError(f"camera: clip={table['clip']!r}; must be '-1..1' or '0..1'")
        return Projection(matrix4(table["projection"], "projection"), table.get("clip", "-1..1"))
    if "intrinsics" in table:
        k = table["intrinsics"]
        if isinstance(k, Mapping):
            fx, fy, cx, cy = (float(k[name]) for name in ("fx", "fy", "cx", "cy"))
        else:
            fx, fy, cx, cy = intrinsics_of(k)
        size = k if isinstance(k, Mapping) else table
        return Pinhole(fx, fy, cx, cy, int(size["width"]), int(size["height"]), znear, zfar)
    if "ortho_height" in table:
        return Orthographic(float(table["ortho_height"]), znear, 1e4 if zfar is None else zfar)
    return Perspective(math.radians(float(table["yfov_deg"])), znear, zfar)
