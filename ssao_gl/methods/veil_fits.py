"""How much of what a depth buffer does not show is hidden: shares fitted to rays, as data.

``veil_fits.json`` is made by ``ssao-gl planner veil`` and says how.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources

from ..errors import SettingsError


@dataclass(frozen=True, slots=True)
class VeilFit:
    """Shares by which sectors are hidden: of slabs, of the veil within 1.5 radii, and of that within 3; and how thick slabs are.

    thickness: in radii. A sector that a slab hides is in both veils, so the three add up to about 1.
    """

    opacity: float
    near_veil: float
    veil: float
    thickness: float


@cache
def veil_fit(kind: str) -> VeilFit:
    """Return the fit of a kind of settings. Raises SettingsError for one without."""
    text = resources.files(__package__).joinpath("veil_fits.json").read_text("utf-8")
    fits = json.loads(text)["fits"]
    if kind not in fits:
        raise SettingsError(f"no shares are fitted for '{kind}'; there are {', '.join(fits)}")
    return VeilFit(**{name: fits[kind][name] for name in ("opacity", "near_veil", "veil", "thickness")})
