"""What a picture can hold, and the resources of the graph that hold it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..errors import SettingsError, near_miss
from ..graph.names import BENT_NORMAL, COLOR, DEPTH, IMAGE, SHADING_NORMAL, VISIBILITY

RESOURCES: Mapping[str, str] = {
    "image": IMAGE,
    "visibility": VISIBILITY,
    "depth": DEPTH,
    "normal": SHADING_NORMAL,
    "bent": BENT_NORMAL,
    "color": COLOR,
}
"""AOV -> resource of the graph: shaded image, visibility, linear depth, view-space normals, mean open directions, base colour."""

AOVS = tuple(RESOURCES)
"""What a picture can hold."""


def aov_resources(aovs: Sequence[str]) -> list[str]:
    """Return the resources of some AOVs. Raises SettingsError for an unknown one."""
    for name in aovs:
        if name not in AOVS:
            raise SettingsError(f"unknown AOV '{name}'; there are {', '.join(AOVS)}.{near_miss(name, AOVS)}")
    wanted = [RESOURCES[name] for name in aovs]
    # Directions are zero on background, which depth tells. Bent normals are drawn beside visibility.
    more = [*([DEPTH] if {"normal", "bent"} & set(aovs) else []), *([VISIBILITY] if "bent" in aovs else [])]
    return list(dict.fromkeys([*wanted, *more]))
