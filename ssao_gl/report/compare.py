"""What got better or worse between two reports, beyond the noise: paired bootstrap over views."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..experiment.points import MEDIAN
from ..experiment.steps import ESTIMATE

F64 = NDArray[np.float64]
DRAWS, COVERED, SEED = 10_000, 95.0, 0
ERROR, TIME = "RMSE", "time"


@dataclass(frozen=True, slots=True)
class Change:
    """One variant, before and after: mean RMSE, or time as a multiple of the baseline.

    low, high: the middle 95 % of the relative change when views are drawn again with replacement.
    """

    label: str
    what: str
    views: int
    before: float
    after: float
    low: float
    high: float

    @property
    def share(self) -> float:
        """Relative change; above 0 is worse."""
        return self.after / self.before - 1 if self.before > 0 else float(self.after > 0)

    @property
    def verdict(self) -> str:
        """Better or worse when all of the interval is on one side of 0."""
        if self.low > 0:
            return "worse"
        return "better" if self.high < 0 else "same"

    def describe(self) -> str:
        """In one line."""
        return f"{self.label}: {self.what} {self.before:.4g} -> {self.after:.4g} ({100 * self.share:+.1f} %)"

    def cells(self) -> tuple[str, ...]:
        """For a table."""
        interval = f"{100 * self.low:+.2f} .. {100 * self.high:+.2f} %"
        numbers = (f"{self.before:.4g}", f"{self.after:.4g}", f"{100 * self.share:+.2f} %")
        return (self.label, self.what, str(self.views), *numbers, interval, self.verdict)


def changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Change]:
    """Of every variant that both reports have, over the views that both have; as shipped."""
    found = []
    old, new = (_by_variant(report) for report in (before, after))
    for label in old:
        views = [view for view in old[label] if view in new.get(label, {})]
        for what in (ERROR, TIME):
            pairs = [(old[label][view][what], new[label][view][what]) for view in views]
            pairs = [(a, b) for a, b in pairs if a is not None and b is not None]
            if pairs:
                a, b = np.array(pairs, np.float64).T
                found.append(Change(label, what, len(pairs), float(a.mean()), float(b.mean()), *interval(a, b)))
    return found


def interval(before: F64, after: F64) -> tuple[float, float]:
    """Bounds of the relative change of the mean, by a paired bootstrap over views with a fixed seed.

    Efron, Tibshirani, "An Introduction to the Bootstrap", 1993: percentile interval. Of a single view it is one point.
    """
    from scipy.stats import bootstrap

    if len(before) < 2:
        share = float(_share(before, after, -1))
        return share, share
    found = bootstrap(
        (before, after), _share, paired=True, vectorized=True, n_resamples=DRAWS, batch=1000, confidence_level=COVERED / 100,
        method="percentile", rng=np.random.default_rng(SEED),
    )  # fmt: skip
    return float(found.confidence_interval.low), float(found.confidence_interval.high)


def _share(before: F64, after: F64, axis: int = -1) -> F64:
    """Relative change of the mean; 1 where there was nothing before and is something now."""
    old, new = before.mean(axis), after.mean(axis)
    return np.asarray(np.where(old > 0, new / np.where(old > 0, old, 1) - 1, (new > 0).astype(float)))


def regressions(found: Sequence[Change], most: float, slowest: float | None) -> list[Change]:
    """Return changes that are worse beyond the noise and by more than a share: ``most`` of the error, ``slowest`` of the
    time."""
    limits = {ERROR: most, TIME: slowest}
    return [
        change
        for change in found
        if change.verdict == "worse" and (limit := limits[change.what]) is not None and change.share > limit
    ]


def _by_variant(report: Mapping[str, Any]) -> dict[str, dict[str, dict[str, float | None]]]:
    """label -> view -> RMSE and time as multiple of the baseline."""
    found: dict[str, dict[str, dict[str, float | None]]] = {}
    for row in report["rows"].get(ESTIMATE, []):
        if "errors" in row:
            found.setdefault(row["variant"], {})[row["view"]] = {ERROR: row["errors"].get("rmse"), TIME: _time(row)}
    return found


def _time(row: Mapping[str, Any]) -> float | None:
    yard = (row.get("baseline") or {}).get("wall", [0, 0, 0])[MEDIAN]
    return row["times"]["total"]["wall"][MEDIAN] / yard if yard > 0 else None
