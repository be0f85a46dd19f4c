"""Which way is up in a file: only automatic views go by it."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import SceneError

Direction = tuple[float, float, float]

Z_UP = frozenset({"stl", "stl_ascii", "3mf", "ply", "off", "xyz", "volume"})
"""Formats in which z is usually up; in all others y is."""
AXES: Mapping[str, Direction] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def up_direction(up: str, kind: str = "") -> Direction:
    """Return the direction of an axis by its name, or by the format for ``auto``. Raises SceneError."""
    if up == "auto":
        return AXES["z" if kind in Z_UP else "y"]
    if up not in AXES:
        raise SceneError(f"up axis '{up}'; must be x, y, z or auto")
    return AXES[up]
