"""How time grows with pixels, with taps and with the radius in pixels; one view, the default settings of each method."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import SettingsError
from ..methods.base import Method
from ..methods.registry import method
from ..pipeline.settings import Settings
from ..scene.projection import Size
from ..settings import assign
from .estimators import ScreenSpace
from .measure import timed
from .points import MEDIAN
from .statistics import exponent
from .sweep import Sweep
from .variants import TRUTH
from .view_setup import ViewSetup
from .views import MeasuredView

PIXELS: tuple[Size, ...] = ((320, 180), (640, 360), (1280, 720), (1920, 1080), (2560, 1440), (3840, 2160))
"""0.06 to 8.3 million pixels."""

SAMPLES = (4, 8, 16, 32)
RADII = (16, 32, 64, 128, 256)
"""Pixels, at the median depth of the view."""

AXES = {"pixels": "pixels", "samples": "taps", "radius": "radius in pixels"}


@dataclass(frozen=True, slots=True)
class Trial:
    """One value on one axis, for one method."""

    method: str
    axis: str
    value: float
    size: Size

    @property
    def at(self) -> str:
        return f"{self.axis} {self.value:g}"


def trials(sweep: Sweep, view: MeasuredView) -> list[Trial]:
    """Every method of the sweep on every axis that it has."""
    found = []
    for name in dict.fromkeys(one.family for one in sweep.methods if one.family != TRUTH):
        record = method(name)
        found += [Trial(name, "pixels", size[0] * size[1], size) for size in PIXELS]
        if record.traits.taps_setting:
            found += [Trial(name, "samples", count, view.size) for count in SAMPLES]
        found += [Trial(name, "radius", radius, view.size) for radius in RADII]
    return found


def together(some: Sequence[Trial]) -> list[list[Trial]]:
    """Trials that take turns in the same rounds: those of one axis and one size."""
    found: dict[tuple[str, Size], list[Trial]] = {}
    for one in some:
        found.setdefault((one.axis, one.size), []).append(one)
    return list(found.values())


def measure_scaling(setup: ViewSetup, some: Sequence[Trial], rounds: int) -> list[dict[str, Any]]:
    """Return times of each trial, or why the method refuses it; all of one size."""
    ready: dict[str, ScreenSpace] = {}
    refused: dict[str, str] = {}
    for number, one in enumerate(some):
        try:
            ready[str(number)] = ScreenSpace(one.method, one.at, Settings(method=_record(setup, one)))
        except SettingsError as error:
            refused[str(number)] = str(error)
    found = timed(dataclasses.replace(setup, size=some[0].size), ready, rounds)
    refused.update(found.refused)
    return [
        {"axis": one.axis, "value": one.value, "baseline": found.baseline, "times": found.times[key]}
        if (key := str(number)) in found.times
        else {"refused": refused[key]}
        for number, one in enumerate(some)
    ]


def _record(setup: ViewSetup, trial: Trial) -> Method:
    record = setup.settled(Settings(method=method(trial.method))).method
    field = record.traits.taps_setting
    if trial.axis == "samples" and field:
        return assign(record, {field: int(trial.value)})
    if trial.axis == "radius":
        return assign(record, {"radius": _radius(setup, record, trial.value)})
    return record


def _radius(setup: ViewSetup, record: Method, pixels: float) -> float:
    """Return the method's radius that covers ``pixels`` at the median depth, in the unit that its radius has."""
    unit = record.traits.radius_unit
    view, depth = setup.camera.view(setup.size), setup.depth[setup.depth > 0]
    z = float(np.median(depth)) if depth.size else 1.0
    if unit == "scene units":
        return pixels * view.pixel * (view.w1 * z + view.w0)
    if unit == "share of the image":
        return pixels / view.size[0] / max(1 - z / view.far, 1e-6)
    return pixels


@dataclass(frozen=True, slots=True)
class Exponents:
    """How the time of a method grows along an axis: ``time ~ value^exponent``; None of fewer than two values.

    first, last: values, and ``ms_first``, ``ms_last``: milliseconds of all passes there. method, total, cpu: exponents of the
    method's own passes, of all passes, and of those by CPU time.
    """

    family: str
    axis: str
    first: float
    last: float
    ms_first: float
    ms_last: float
    method: float | None
    total: float | None
    cpu: float | None


def exponents(rows: Sequence[Mapping[str, Any]]) -> list[Exponents]:
    """Fit an exponent to each method on each axis, by least squares of logarithms."""
    found = []
    for (name, axis), some in series(rows).items():
        values = [row["value"] for row in some]
        own, total = ([row["times"][part]["wall"][MEDIAN] for row in some] for part in ("method", "total"))
        cpu = [row["times"]["total"]["cpu"][MEDIAN] for row in some]
        fitted = [exponent(values, times) if min(times) > 0 else None for times in (own, total, cpu)]
        found.append(Exponents(name, axis, values[0], values[-1], total[0], total[-1], *fitted))
    return found


def series(rows: Sequence[Mapping[str, Any]]) -> dict[tuple[str, str], list[Mapping[str, Any]]]:
    """Return (method, axis) -> rows by rising value."""
    found: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in sorted((row for row in rows if "times" in row), key=lambda row: float(row["value"])):
        found.setdefault((row["variant"], row["axis"]), []).append(row)
    return found
