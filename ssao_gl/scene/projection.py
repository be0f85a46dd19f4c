"""The constants by which shaders turn pixels and linear depth into points, for any projection.

Conventions, for the whole package: right-handed view space with the eye at 0, x right, y up, looking along -z. Linear depth
is ``z = -z_view > 0`` in scene units; 0 means background. Texture coordinates ``uv`` run from (0, 0) at the lower left
to (1, 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError

Matrix = NDArray[np.float64]
Size = tuple[int, int]
"""(width, height) in pixels."""

MAX_SIDE = 1 << 16
"""Of an image, pixels."""


def pixel_size(size: Any) -> Size:
    """Return (width, height) as whole numbers from two numbers, whole floats too. Raises SettingsError unless sides are 1 to 65536."""
    try:
        w, h = (int(side) for side in size if not isinstance(side, str))
        fits = (w, h) == tuple(size) and min(w, h) >= 1 and max(w, h) <= MAX_SIDE
    except (TypeError, ValueError, OverflowError):
        fits = False
    if not fits:
        shown = "x".join(map(str, size)) if isinstance(size, tuple | list) else repr(size)
        raise SettingsError(
            f"size {shown}: must be (width, height) in whole pixels, sides from 1 to {MAX_SIDE}, like (1280, 720)"
        )
    return w, h


@dataclass(frozen=True, eq=False)
class ViewConstants:
    """What shaders need of a projection at one image size. Nothing here assumes a symmetric frustum.

    A pixel at ``uv`` with linear depth ``z`` shows the view-space point with ``z_view = -z`` and
    ``xy = (ray @ uv + ray0) * z + (org @ uv + org0)``; clip w is ``w1 * z + w0``. A world-space offset ``d`` parallel to
    the image moves ``uv`` by ``uv_per_unit @ d / w``. (Solved from the x, y and w rows of the projection.)
    """

    size: Size
    projection: Matrix
    whole: Size | None = None
    """Size of the image that this is a part of; None when it is an image of its own."""

    def __post_init__(self) -> None:
        m = self.projection
        if not np.isfinite(m).all():
            raise SettingsError("camera: the projection has numbers that are not finite")
        with np.errstate(all="ignore"):
            rows = m[:2, :2] / np.linalg.norm(m[:2, :2], axis=1, keepdims=True)
            flat = not abs(np.linalg.det(rows)) > 1e-12
        if flat:
            raise SettingsError("camera: the projection flattens the image (its upper left 2x2 block is singular)")
        if np.abs(m[3, :2]).max() > 1e-9 * np.abs(m[3]).max():
            raise SettingsError("camera: projections whose w depends on x or y are not supported")
        if m[3, 2] > 0:
            raise SettingsError("camera: the projection looks along +z; ssao_gl's view space looks along -z")
        self._check_constants()

    def _check_constants(self) -> None:
        """Raise SettingsError unless what shaders get is finite as 32-bit floats."""
        try:
            with np.errstate(all="ignore"):
                parts = [*self.constants.values(), *self.depth_constants.values(), self.pixel, self.near]
                usable = all(np.isfinite(np.asarray(part, np.float32)).all() for part in parts)
        except np.linalg.LinAlgError:
            raise SettingsError(
                "camera: the projection cannot be inverted; do its rows for depth and w say anything?"
            ) from None
        if not usable or not self.pixel > 0 or not self.near < self.far:
            raise SettingsError("camera: the projection's numbers are too large or too small for 32-bit floats")

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
