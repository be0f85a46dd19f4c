"""What the planner chooses from: settings on the front of error against time, and beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import SettingsError, near_miss
from ..methods.base import Method
from ..methods.registry import method, presets_of
from ..settings import assign

SECOND_LAYER: Mapping[str, Any] = {"layers": 2, "layer_scale": 4, "refine": 0.02}
FULL_SIZE: Mapping[str, Any] = {"scale": 1, "slices": 1}


TELLING = ("scale", "layers", "steps", "samples")
"""Settings that a candidate is named by."""


@dataclass(frozen=True)
class Candidate:
    """Settings of a method, all but the radius."""

    method: str
    fields: Mapping[str, Any]

    @property
    def name(self) -> str:
        """By its preset if it is one, else by what tells it from others: ``bitmask medium``, ``bitmask scale=2 steps=7``."""
        for preset, fields in presets_of(self.method).items():
            if self.made() == assign(method(self.method), fields):
                return f"{self.method} {preset}"
        return " ".join([self.method, *(f"{key}={self.fields[key]}" for key in TELLING if key in self.fields)])

    @property
    def layers(self) -> int:
        """How many layers of the scene it looks at."""
        return int(self.fields.get("layers", 1))

    def made(self, radius: float | None = None) -> Method:
        """Return the method with these settings and a radius, scene units."""
        made: Method = assign(method(self.method), {**self.fields, "radius": radius})
        return made


@dataclass(frozen=True)
class Family:
    """Candidates that differ in one number, the taps, in which the cost of a pixel is linear."""

    method: str
    fixed: Mapping[str, Any]
    varied: str
    values: Sequence[int]
    """In rising order."""
    probed: tuple[int, int]
    """Two whose frames tell what all cost. Shaders compile longer than they draw, so these are such as others need too."""

    @property
    def name(self) -> str:
        """By what its candidates have in common."""
        return " ".join([self.method, *(f"{key}={self.fixed[key]}" for key in TELLING if key in self.fixed)])

    def candidate(self, value: int) -> Candidate:
        return Candidate(self.method, {**self.fixed, self.varied: value})

    def taps(self, candidate: Candidate) -> int:
        """Return the number that its candidates differ in."""
        return int(candidate.fields[self.varied])

    @property
    def candidates(self) -> list[Candidate]:
        return [self.candidate(value) for value in self.values]


FAMILIES = (
    Family("bitmask", {"scale": 4}, "steps", (2, 4, 8), (5, 9)),
    Family("bitmask", {"scale": 2}, "steps", (3, 5, 7, 9, 14), (5, 9)),
    Family("bitmask", {"scale": 2, **SECOND_LAYER}, "steps", (5, 8, 12), (5, 12)),
    Family("bitmask", FULL_SIZE, "steps", (5, 8, 10, 16), (5, 10)),
    Family("bitmask", {**FULL_SIZE, "layers": 2, "layer_scale": 2}, "steps", (8, 12, 20), (8, 12)),
    Family("alchemy", {}, "samples", (4, 8, 16, 32), (4, 16)),
)

CANDIDATES: Mapping[str, tuple[Family, Candidate]] = {
    candidate.name: (family, candidate) for family in FAMILIES for candidate in family.candidates
}
"""Name -> its family, itself."""

PROBES: Mapping[str, tuple[str, str]] = {
    "bitmask": ("bitmask low", "bitmask scale=2 layers=2 steps=5"),
    "alchemy": ("alchemy draft", "alchemy draft"),
}
"""Method -> the candidates whose frame of a view is timed: where there is one layer, and where there are two."""


def chosen_from(names: Sequence[str], layers: int) -> list[Candidate]:
    """Return the candidates of some methods (all when none are named) that look at no more than ``layers``. Raises
    SettingsError."""
    known = list(PROBES)
    for name in names:
        if name not in known:
            raise SettingsError(
                f"nothing is known of '{name}' to plan by; the planner chooses from {', '.join(known)}.{near_miss(name, known)}"
            )
    return [c for _, c in CANDIDATES.values() if c.layers <= layers and (not names or c.method in names)]


def differing(given: Method) -> list[str]:
    """Return the settings of a method, but the radius, that are not as shipped: the planner would overrule them."""
    shipped = method(given.name)
    return [
        f"{field.name}={getattr(given, field.name)}"
        for field in dataclasses.fields(given)  # type: ignore[arg-type]
        if field.name != "radius" and getattr(given, field.name) != getattr(shipped, field.name)
    ]
