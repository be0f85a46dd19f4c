"""What a picture can hold, and the resources of the graph that hold it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..errors import SettingsError, near_miss
from ..passes.bent_normals import BENT

AOVS = ("image", "visibility", "depth", "normal", "bent", "color")
"""What a picture can hold: shaded image, visibility, linear depth, view-space normals, mean open directions, base colour."""

RESOURCES: Mapping[str, str] = {
    "image": "image",
    "visibility": "visibility",
    "depth": "z",
    "normal": "shading_normal",
    "bent": BENT,
    "color": "color",
}
"""AOV -> resource of the graph."""


def aov_resources(aovs: Sequence[str]) -> list[str]:
    """Resource names of some AOVs. Raises SettingsError for an unknown one."""
    for name in aovs:
        if name not in AOVS:
            raise SettingsError(f"unknown AOV '{name}'; there are {', '.join(AOVS)}.{near_miss(name, AOVS)}")
    wanted = [RESOURCES[name] for name in aovs]
    # Directions are zero on background, which depth tells. Bent normals are drawn beside visibility.
    more = [*(["z"] if {"normal", "bent"} & set(aovs) else []), *(["visibility"] if "bent" in aovs else [])]
    return list(dict.fromkeys([*wanted, *more]))
