"""What got better or worse between two reports: in each view, and beyond the noise, by a paired bootstrap over views."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..experiment.points import MEDIAN
from ..experiment.steps import ESTIMATE
from ..metrics.zones import ZONES

F64 = NDArray[np.float64]
DRAWS, COVERED, SEED = 10_000, 95.0, 0
ERROR, TIME = "RMSE", "time"
ERRORS = {ERROR: "rmse", **{zone: f"rmse_{zone}_net" for zone in ZONES}, "blotches": "blotches_net"}
"""What is compared, beside the time as a multiple of the baseline -> its key in a report."""

ALIKE = {**dict.fromkeys(ERRORS, 0.005), TIME: 0.05}
"""What is compared -> the share up to which a change in one view is none."""

Values = Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class ViewChange:
    """One variant in one view: what is compared -> its value before and after, None where a report has none."""

    view: str
    label: str
    before: Values
    after: Values

    def share(self, what: str) -> float | None:
        """Relative change; above 0 is worse. 1 where there was nothing and is something."""
        old, new = self.before.get(what), self.after.get(what)
        return None if old is None or new is None else float(_share(np.array([old]), np.array([new])))

    def verdict(self, what: str = ERROR) -> str:
        """Better or worse when it changed by more than what is none."""
        share = self.share(what) or 0.0
        return "same" if abs(share) <= ALIKE[what] else "worse" if share > 0 else "better"

    def describe(self) -> str:
        """In one line."""
        numbers = f"{self.before[ERROR]:.4g} -> {self.after[ERROR]:.4g} ({100 * (self.share(ERROR) or 0):+.1f} %)"
        return f"{self.label} in {self.view}: {ERROR} {numbers}"


@dataclass(frozen=True, slots=True)
class Change:
    """One variant, before and after: a mean error, or time as a multiple of the baseline.

    better, worse: views in which it changed. low, high: the middle 95 % of the relative change of the mean when views are drawn
    again with replacement.
    """

    label: str
    what: str
    views: int
    better: int
    worse: int
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


def view_changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[ViewChange]:
    """Of every variant in every view that both reports have; as shipped, the worst first by RMSE."""
    old, new = (_values(report) for report in (before, after))
    found = [ViewChange(*key, old[key], new[key]) for key in old if key in new]
    return sorted(found, key=lambda one: -(one.share(ERROR) or 0.0))


def changes(views: Sequence[ViewChange]) -> list[Change]:
    """Return the changes of means over views, of every variant; that whose RMSE grew most first."""
    by_label: dict[str, list[ViewChange]] = {}
    for one in views:
        by_label.setdefault(one.label, []).append(one)
    found = {label: _changes(label, some) for label, some in by_label.items()}
    ranked = sorted(found.values(), key=lambda some: -max((one.share for one in some if one.what == ERROR), default=0.0))
    return [one for some in ranked for one in some]


def _changes(label: str, views: Sequence[ViewChange]) -> list[Change]:
    found = []
    for what in (*ERRORS, TIME):
        some = [one for one in views if one.share(what) is not None]
        if some:
            a, b = np.array([(one.before[what], one.after[what]) for one in some], np.float64).T
            verdicts = [one.verdict(what) for one in some]
            better, worse = (verdicts.count(verdict) for verdict in ("better", "worse"))
            found.append(Change(label, what, len(some), better, worse, float(a.mean()), float(b.mean()), *interval(a, b)))
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
    """Return changes that are worse beyond the noise and by more than a share: ``most`` of the RMSE, ``slowest`` of the time."""
    limits = {ERROR: most, TIME: slowest}
    return [
        change
        for change in found
        if change.verdict == "worse" and (limit := limits.get(change.what)) is not None and change.share > limit
    ]


def view_regressions(found: Sequence[ViewChange], most: float | None) -> list[ViewChange]:
    """Return changes in single views whose RMSE grew by more than a share; none without a limit."""
    return [one for one in found if most is not None and (one.share(ERROR) or 0.0) > most]


def unlike(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """Return in which of their settings two reports differ, so that figures may have changed for that alone."""
    old, new = (report.get("settings", {}) for report in (before, after))
    return [key for key in {**old, **new} if key not in ("code", "format") and old.get(key) != new.get(key)]


def _values(report: Mapping[str, Any]) -> dict[tuple[str, str], Values]:
    """(view, label) -> errors, and time as multiple of the baseline."""
    return {
        (row["view"], row["variant"]): {what: row["errors"].get(key) for what, key in ERRORS.items()} | {TIME: _time(row)}
        for row in report["rows"].get(ESTIMATE, [])
        if "errors" in row
    }


def _time(row: Mapping[str, Any]) -> float | None:
    yard = (row.get("baseline") or {}).get("wall", [0, 0, 0])[MEDIAN]
    return row["times"]["total"]["wall"][MEDIAN] / yard if yard > 0 else None
