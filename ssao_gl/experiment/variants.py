"""What is compared: every method under its presets, or under ranges of its settings."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence

from ..errors import SettingsError, near_miss
from ..methods.base import Method
from ..methods.lecture import Lecture
from ..methods.registry import check_presets, general, method, presets_of
from ..pipeline.settings import Settings
from ..settings import assign
from .estimators import DEFAULT, ScreenSpace

TRUTH = "reference"
"""The method that is truth itself, to screen space: too slow to be swept unless it is asked for."""


BASELINE = ScreenSpace("lecture", "4 taps, no filter", Settings(method=Lecture(), blur=None, keep=("background",)))
"""What times are given as multiples of: the lecture's pass alone, 4 taps, timed in the same rounds."""


def variants(methods: Sequence[str] = (), presets: Sequence[str] = (), ranges: Iterable[str] = ()) -> list[ScreenSpace]:
    """Methods (all but those that may take minutes when none are named) times their presets (all), or times ``ranges``.

    ranges: texts like ``alchemy.samples=4,8,16``; several make every combination, upon the method's defaults or the
    named presets. A method without any of the named presets takes part as it is. Raises SettingsError for unknown names.
    """
    for name in methods:
        method(name)
    chosen = list(dict.fromkeys(methods)) or [
        name for name in general() if name != TRUTH and method(name).traits.elements is None
    ]
    spreads = _spreads(ranges, chosen)
    found = [
        ScreenSpace(name, label, Settings(method=record))
        for name in chosen
        for label, record in _records(name, presets, spreads.get(name, {})).items()
    ]
    check_presets(presets, (label for name in chosen for label in (DEFAULT, *presets_of(name))))
    return found


def _records(name: str, presets: Sequence[str], spread: Mapping[str, list[str]]) -> dict[str, Method]:
    """preset -> settings of the method."""
    shipped = method(name)
    records: dict[str, Method] = {label: assign(shipped, values) for label, values in presets_of(name).items()}
    if shipped not in records.values():
        records = {DEFAULT: shipped, **records}
    if presets:
        records = {label: record for label, record in records.items() if label in presets} or {DEFAULT: shipped}
    elif spread:
        records = {DEFAULT: shipped}
    if not spread:
        return records
    return {
        " ".join([*([] if label == DEFAULT else [label]), *(f"{k}={v}" for k, v in zip(spread, values, strict=True))]): assign(
            record, dict(zip(spread, values, strict=True))
        )
        for label, record in records.items()
        for values in itertools.product(*spread.values())
    }


def _spreads(ranges: Iterable[str], chosen: Sequence[str]) -> dict[str, dict[str, list[str]]]:
    """Return method -> field -> values as text."""
    found: dict[str, dict[str, list[str]]] = {}
    for text in ranges:
        key, equals, values = text.partition("=")
        name, dot, field = key.strip().partition(".")
        listed = [value.strip() for value in values.split(",") if value.strip()]
        if not (dot and equals and listed):
            raise SettingsError(f"--set {text}: must be method.setting=value,value,..., like alchemy.samples=4,8,16")
        if name not in chosen:
            raise SettingsError(f"--set {text}: no method '{name}' in this report.{near_miss(name, chosen)}")
        found.setdefault(name, {})[field] = listed
    return found
