"""The depth buffer's range: fitted to what can be seen, in logarithms where that is much."""

from __future__ import annotations

import math

from ..scene.projection import Matrix, ViewConstants

STIFF = 1 << 12
"""Ratio of far to near from which depth is drawn in logarithms, at the price of an early depth test: beyond it a step of
24-bit depth is more than 1/4000 of the far distance."""


def fit_depth_range(view: ViewConstants, nearest: float, farthest: float) -> Matrix:
    """Return the projection of ``view`` with its depth row rebuilt so that the depth buffer spans just what can be seen.

    The clip planes stay where the camera put them unless the scene lies between them. Reversed, infinite and 0..1
    projections become OpenGL's -1..1, so one depth test serves all; x, y and w are untouched.
    """
    near, far = view.near, view.far
    margin = 1e-3 * (farthest - nearest) + 1e-6 * max(abs(nearest), abs(farthest))
    near = max(near, nearest - margin)
    far = min(far, max(farthest + margin, near * (1 + 1e-3) + margin))
    if not far > near:  # the whole scene lies outside: any valid range will do, everything is clipped
        near, far = view.near, view.near + max(abs(view.near), 1.0)
    m = view.projection.copy()
    w = {z: view.w1 * z + view.w0 for z in (near, far)}
    slope = (w[far] + w[near]) / (far - near)
    m[2] = (0, 0, -slope, -w[near] - slope * near)
    return m


def near_one(w: float) -> float:
    """Return the power of two that brings clip coordinates with this w near 1: some drivers square them."""
    return math.ldexp(1.0, -min(max(math.frexp(w)[1], -1000), 1000)) if w and math.isfinite(w) else 1.0


def log_depth(view: ViewConstants, projection: Matrix) -> tuple[Matrix, tuple[float, float]] | None:
    """For ranges in which plain depth would not tell far surfaces apart: what draws depth in logarithms; None for others.

    That is the projection with its far plane at infinity (32-bit floats would miss a plane so near to 1; depth above 1 fails
    the test instead), and (1 / near, 1 / log2(far / near)). A step of plain depth is the share ``far / near 2^-24`` of the
    far distance, a step of its logarithm ``ln(far / near) 2^-24`` of any.
    """
    if view.w0 != 0 or view.w1 == 0:
        return None
    ends = [end * view.w1 - float(projection[2, 2]) for end in (1, -1)]
    if 0 in ends:  # no range at all: everything is clipped
        return None
    near, far = (-float(projection[2, 3]) / end for end in ends)
    if not far > STIFF * near > 0:
        return None
    endless = projection.copy()
    endless[2] = (0, 0, -view.w1, -2 * view.w1 * near)
    return endless, (1 / near, 1 / math.log2(far / near))
