"""What a caller asks of the readers of scene files."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ReadOptions:
    """See :func:`ssao_gl.load_scene`."""

    crease: float = math.radians(40)
    animation: str | None = None
    time: float = 0.0
    point_size: float | None = None

    @property
    def point_radius(self) -> float | None:
        """Half the size of points, scene units."""
        return None if self.point_size is None else self.point_size / 2
