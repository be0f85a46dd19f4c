"""What blocks rays: the protocol that triangles, spheres and volumes answer, in local coordinates."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

DIAMETER = 4.0
"""Above the diagonal of the local box, which is at most 2 sqrt(3)."""

OFFSET = 2.0**-20
"""How far from its triangle a ray starts, in local units.

Coordinates below 1 round to 32-bit floats within 2^-25, which moves a plane or a point by at most sqrt(3) 2^-25; the
start, its own triangle and a triangle beside it in the same plane make three of these, and Embree's edge functions
work on differences up to 2 sqrt(3) with errors of a few 2^-24. 2^-20 is above the sum of them all. The bound is the
scene's, not the triangle's: the neighbour may be far larger. (Offsetting along the geometric normal by the reach of
rounding errors: Waechter & Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, 2019.)
"""


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """First hits of those rays that met something.

    rays: (m,) which of the rays, ascending. distance: (m,) along them, in lengths of their directions. points, normals,
    shading: (m, 3) in local coordinates, the surface's own normals and those for shading, of any length and on any side; a
    shading normal of length 0 is none.
    """

    rays: NDArray[np.int64]
    distance: F32
    points: F64
    normals: F64
    shading: F64


class Blockers(Protocol):
    """What rays (n, 3) float32 meet. Calls may come from several threads at once."""

    def occluded(self, origins: F32, directions: F32, reach: float) -> NDArray[Any]:
        """Return how much of each ray is blocked nearer than ``reach``: bool (n,), or shares in 0..1 of what is not solid."""

    def distances(self, origins: F32, directions: F32, reach: float) -> F32:
        """Return the distance (n,) to the first hit of each ray, ``reach`` where there is none."""

    def hits(self, origins: F32, directions: F32, reach: F32) -> Hits:
        """Return the first hits within ``reach`` (n,)."""


def machine_memory() -> float:
    """Bytes of memory of this machine; infinite where it does not say."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf


def check_memory(name: str, contents: str, need: float, where: str) -> None:
    """Raise SceneError where a scene called ``name`` needs more bytes than this machine has. ``contents``: what does, in words."""
    have = machine_memory()
    if need > have:
        raise SceneError(
            f"{name}: {contents} (instances counted each) need about {need / 2**30:.1f} GiB {where};"
            f" this machine has {have / 2**30:.1f} GiB. Trace a part of it, or fewer instances"
        )


def threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
