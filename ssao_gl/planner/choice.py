"""Which of several predictions suits a target."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import SettingsError
from ..pipeline.settings import Settings
from ..render.picture import Picture

CLOCKS: Mapping[str, str] = {
    "cpu": "CPU time of all threads",
    "gpu": "GPU time",
    "wall": "wall clock",
}
"""What milliseconds are counted by: the work itself on software renderers, GL's timer where there is one, else the wall clock."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """What is asked for: milliseconds that a frame may take, RMSE of visibility against rays that it may have, or both."""

    budget_ms: float | None = None
    max_error: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("budget_ms", self.budget_ms), ("max_error", self.max_error)):
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if value is not None and not (number and math.isfinite(value) and value > 0):
                raise SettingsError(f"{name}={value!r}: must be a finite number above 0")
        if self.budget_ms is None and self.max_error is None:
            raise SettingsError("nothing to plan for: give budget_ms, max_error or both")

    def describe(self) -> str:
        """In words."""
        budget = "" if self.budget_ms is None else f"at most {self.budget_ms:.4g} ms"
        error = "" if self.max_error is None else f"an RMSE of at most {self.max_error:.4g}"
        return " and ".join(part for part in (budget, error) if part)


@dataclass(frozen=True, slots=True)
class Prediction:
    """What a frame is expected to take, milliseconds of all its passes, and its RMSE of visibility against rays."""

    name: str
    ms: float
    error: float

    def describe(self) -> str:
        """In words."""
        return f"{self.name}: {self.ms:.3g} ms, RMSE {self.error:.3f}"


@dataclass(frozen=True, slots=True)
class Choice:
    """What the planner chose: settings to render with, what they are predicted to take, and what else there was."""

    settings: Settings
    target: Target
    prediction: Prediction
    considered: tuple[Prediction, ...]
    """By rising time."""
    clock: str
    """By which milliseconds are counted, of ``CLOCKS``."""

    def noted(self, picture: Picture) -> Picture:
        """Return a timed picture by these settings, with the prediction beside what it took in its report, as ``planned``."""
        took = sum(times(picture.report["passes"], self.clock).values())
        planned = {
            "budget_ms": self.target.budget_ms,
            "max_error": self.target.max_error,
            "chosen": self.prediction.name,
            "of": len(self.considered),
            "clock": self.clock,
            "predicted_ms": self.prediction.ms,
            "took_ms": took,
            "predicted_error": self.prediction.error,
        }
        return dataclasses.replace(picture, report={**picture.report, "planned": planned})


def times(passes: Sequence[Mapping[str, Any]], clock: str) -> dict[str, float]:
    """Milliseconds by pass, of the passes of a picture's report, by one of the clocks."""
    return {one["name"]: one["cpu_ms" if clock == "cpu" else "ms"] for one in passes}


def choose(predictions: Sequence[Prediction], target: Target) -> Prediction:
    """Return the least error within the budget; without one, the least time within the error. Ties go to the cheaper, then
    the better.

    Raises SettingsError, which names what comes nearest, when nothing is within the target.
    """
    budget = math.inf if target.budget_ms is None else target.budget_ms
    bound = math.inf if target.max_error is None else target.max_error
    fit = [p for p in predictions if p.ms <= budget and p.error <= bound]
    if fit:
        return min(fit, key=lambda p: (p.ms, p.error) if target.max_error is not None else (p.error, p.ms))
    # The nearest of what cannot be had: by the factor that it is off.
    nearest = min(predictions, key=lambda p: (max(p.ms / budget, p.error / bound), p.ms))
    raise SettingsError(f"{target.describe()} is out of reach here; the nearest is {nearest.describe()}")
