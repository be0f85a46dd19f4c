"""What a picture can hold, and the resources of the graph that hold it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..errors import SettingsError, near_miss
from ..graph.names import BENT_NORMAL, COLOR, DEPTH, IMAGE, LABELS, SHADING_NORMAL, VISIBILITY

MASKS: Mapping[str, int] = {"object": 0, "instance": 1, "material": 2}
"""AOVs of whole numbers -> their place in :data:`ssao_gl.graph.names.LABELS`."""

RESOURCES: Mapping[str, str] = {
    "image": IMAGE,
    "visibility": VISIBILITY,
    "depth": DEPTH,
    "normal": SHADING_NORMAL,
    "bent": BENT_NORMAL,
    "color": COLOR,
    **dict.fromkeys(MASKS, LABELS),
}
"""AOV -> resource of the graph: shaded image, visibility, linear depth, view-space normals, mean open directions, base colour, and masks."""

AOVS = tuple(RESOURCES)
"""What a picture can hold."""


def aov_names(aovs: str | Sequence[str]) -> tuple[str, ...]:
    """Return names of AOVs from themselves or from one text with names by commas. Raises SettingsError for an unknown one, or none."""
    parts = aovs.split(",") if isinstance(aovs, str) else aovs
    if not isinstance(parts, Sequence) or not all(isinstance(part, str) for part in parts):
        raise SettingsError(f"aovs={aovs!r}: must be names, like ('image', 'depth'); there are {', '.join(AOVS)}")
    names = tuple(dict.fromkeys(part.strip() for part in parts if part.strip()))
    if not names:
        raise SettingsError(f"no AOV: name at least one of {', '.join(AOVS)}")
    aov_resources(names)
    return names


def aov_resources(aovs: Sequence[str]) -> list[str]:
    """Return the resources of some AOVs. Raises SettingsError for an unknown one."""
    for name in aovs:
        if name not in AOVS:
            raise SettingsError(f"unknown AOV '{name}'; there are {', '.join(AOVS)}.{near_miss(name, AOVS)}")
    wanted = [RESOURCES[name] for name in aovs]
    # Directions are zero on background, which depth tells. Bent normals are drawn beside visibility.
    more = [*([DEPTH] if {"normal", "bent"} & set(aovs) else []), *([VISIBILITY] if "bent" in aovs else [])]
    return list(dict.fromkeys([*wanted, *more]))
