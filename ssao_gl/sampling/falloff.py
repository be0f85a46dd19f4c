"""How much a blocker counts with its distance: one enum for ray-traced truth and for screen-space methods.

Occlusion is ``(1/pi) integral of rho(d / R) cos(theta) d(omega)`` over the hemisphere, with ``d`` the distance to the
first hit and ``R`` the radius; visibility is 1 minus that. ``rho`` weighs occlusion: it is 0 from ``R`` on, so that
open sky gives visibility 1. (Zhukov, Iones, Kronin, "An Ambient Light Illumination Model", EGRW 1998, and Mendez,
Sbert, Cata, "Real-time Obscurances with Color Bleeding", SCCG 2003, write the opposite, openness ``1 - rho``.)
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

CORNER = math.pi / (8 * math.log(1 + math.sqrt(2)))
"""Sigma over the radius for which a point in the corner of two walls is half occluded, seen along the corner's
bisector. There the estimator's mean over the disk is ``2 sigma/(pi R^2) * 2 R ln(1 + sqrt 2)`` (with h and b the
height on the wall and the way along it, ``h/(h^2+b^2)`` integrated over the half disk ``h = sqrt 2 a``), and the true
cosine-weighted occlusion is 1/2."""


class Falloff(StrEnum):
    """Shapes of rho, with ``x = d / R``; all are 0 from ``x = 1`` on.

    hard: 1. A hit counts when it is nearer than the radius, however near: ambient occlusion with a cut.
    quadratic: ``(1 - x)^2``.
    obscurance: ``1 - sqrt(x)``, Mendez's openness ``sqrt(d / R)`` turned into occlusion. (Lecture "Ambient occlusion",
    UPC Barcelona: its slide writes the integral of openness as if it were occlusion; here the sign is put right.)
    alchemy: ``u x / max(u, x)^2`` with ``u = sigma / R``: rises from 0 to 1 at ``x = u`` and falls as ``u / x``. The
    falloff that Alchemy's estimator integrates (McGuire, Osman, Bukowski, Hennessy, HPG 2011), with the sigma of
    :class:`ssao_gl.Alchemy` at intensity 1.
    """

    HARD = "hard"
    QUADRATIC = "quadratic"
    OBSCURANCE = "obscurance"
    ALCHEMY = "alchemy"


def rho(falloff: Falloff | str, share: ArrayLike) -> NDArray[Any]:
    """rho of distances as shares of the radius (any shape, >= 0; inf for no hit), in 0..1, of the same float type."""
    x = np.asarray(share)
    if x.dtype.kind != "f":
        x = x.astype(np.float64)
    near = np.minimum(x, x.dtype.type(1))
    match Falloff(falloff):
        case Falloff.HARD:
            rho = np.ones_like(near)
        case Falloff.QUADRATIC:
            rho = (1 - near) ** 2
        case Falloff.OBSCURANCE:
            rho = 1 - np.sqrt(near)
        case Falloff.ALCHEMY:
            rho = CORNER * near / np.maximum(CORNER, near) ** 2
    return np.asarray(np.where(x < 1, rho, x.dtype.type(0)))
