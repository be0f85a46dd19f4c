"""Where rays start on a surface: just off its triangle, on the side that counts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..truth.rays import OFFSET, RayScene
from ..truth.surface import interpolated, side, unit

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]


def starts(rays: RayScene, parts: I64, triangles: I64, u: F64, v: F64, towards: float) -> tuple[F32, F32]:
    """Origins (n, 3) in local units and unit normals (n, 3) of points on triangles, u and v their barycentric coordinates.

    The front is where the vertex normals point to; where there are none, from where corners run counterclockwise (glTF 2.0,
    3.7.2.1). ``towards``: 1 front, -1 back.
    """
    points, normals, shading = interpolated(rays, {"u": u, "v": v, "primID": triangles, "geomID": parts})
    normals = unit(normals, np.array([0.0, 0.0, 1.0]))
    normals *= side(normals, shading) * (rays.handedness[parts] * towards)[:, None]
    return (points + OFFSET * normals).astype(np.float32), normals.astype(np.float32)
