"""Depth images by casting one ray a pixel in 64-bit: exact, for any projection, without OpenGL."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..scene.camera import Camera
from ..scene.projection import Size

F64 = NDArray[np.float64]
AnalyticSurface = Callable[[F64, F64], F64]
"""From ray starts and steps (h, w, 3) to the depths (h, w) at which rays meet it first; inf where they do not. A ray's point
at depth z is ``start + z step``."""


def cast(camera: Camera, size: Size, *surfaces: AnalyticSurface) -> F64:
    """(h, w) eye depth of the nearest surface in view space, 0 where there is none; row 0 on top."""
    view = camera.view(size)
    one = np.ones(size[::-1])
    near, far = view.points(one), view.points(2 * one)
    step, start = far - near, 2 * near - far
    with np.errstate(all="ignore"):
        z = np.min([surface(start, step) for surface in surfaces], axis=0)
    return np.where(np.isfinite(z), z, 0.0)


def flat(through: ArrayLike, normal: ArrayLike, within: float = np.inf) -> AnalyticSurface:
    """Return the plane through a point at right angles to ``normal``, as far as ``within`` from the point."""
    p, n = np.asarray(through, np.float64), np.asarray(normal, np.float64)

    def meet(start: F64, step: F64) -> F64:
        z = ((p - start) @ n) / (step @ n)
        off = np.linalg.norm(start + z[..., None] * step - p, axis=-1)
        return _ahead(z, off <= within)

    return meet


def ball_depth(center: ArrayLike, radius: float) -> AnalyticSurface:
    """Return a sphere, seen from outside."""
    middle = np.asarray(center, np.float64)

    def meet(start: F64, step: F64) -> F64:
        off = start - middle
        a, b, c = (step**2).sum(-1), (step * off).sum(-1), (off**2).sum(-1) - radius**2
        return _ahead((-b - np.sqrt(b * b - a * c)) / a, b * b > a * c)

    return meet


def _ahead(z: F64, met: NDArray[np.bool_]) -> F64:
    """Depths in front of the camera where rays meet the surface, inf elsewhere."""
    return np.where(met & (z > 0), z, np.inf)


def room(scale: float = 1.0) -> tuple[AnalyticSurface, ...]:
    """Return a ball on a floor before a wall, with sky beside it: what the depth cases look at. Some 5 ``scale`` away."""
    s = scale
    return (
        flat((0, -s, 0), (0, 1, 0)),
        flat((-1.5 * s, 0, -7 * s), (0, 0, 1), within=3.5 * s),
        ball_depth((0.2 * s, -0.4 * s, -5 * s), 0.6 * s),
    )


def window_depth(camera: Camera, z: NDArray[Any], dtype: Any = np.float32) -> NDArray[Any]:
    """(h, w) what a depth buffer holds for eye depth ``z``, background at the far plane; rounded to ``dtype`` last."""
    view = camera.view(z.shape[::-1])
    m = view.projection
    ndc = (-m[2, 2] * z + m[2, 3]) / (view.w1 * z + view.w0 + (z == 0))
    return np.asarray(np.where(z > 0, 0.5 + 0.5 * ndc, view.depth_constants["u_depth_far"]), dtype)


def as_half_floats(depth: NDArray[Any], bits: int) -> NDArray[np.float64]:
    """Window depth 0..1 as a depth buffer of so many bits keeps it."""
    top = 2.0**bits - 1
    return np.asarray(np.round(np.clip(depth, 0, 1) * top) / top)
