"""What the rules of leaving out save in a view: the default method under settings that bring each of them into force."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from ..methods.base import Method
from ..pipeline.settings import Settings
from ..settings import assign
from .culling_savings import benchmark_rules
from .view_setup import ViewSetup

FULL_SIZE = "high"
"""The preset at which rules are measured, too: where more taps make them pay."""

MOST_VIEWS = 6
"""Up to so many views have their rules measured unless it is said otherwise."""

MOST_ROUNDS = 3


def subjects() -> dict[str, Method]:
    """Return the default method under settings that bring each rule into force, by a label for each."""
    shipped = Settings().method
    found: dict[str, Method] = {shipped.name: shipped}
    if FULL_SIZE in shipped.presets:
        found[f"{shipped.name} {FULL_SIZE}"] = assign(shipped, shipped.presets[FULL_SIZE])
    if probe := shipped.traits.probe_setting:
        found[f"{shipped.name} {probe}"] = assign(shipped, {probe: True})
    return found


def measure_rules(setup: ViewSetup, rounds: int, tell: Callable[[float], None]) -> list[dict[str, Any]]:
    """Benchmark every rule in force under each of the settings, and all together.

    Returns the fields of :class:`.culling_savings.RuleBenchmark` as plain values.
    """
    found = []
    chosen = subjects()
    for number, (label, method) in enumerate(chosen.items(), 1):
        settings = setup.settled(Settings(method=method))
        for one in benchmark_rules(
            setup.renderer, setup.scene, setup.camera, setup.size, settings, rounds=max(1, min(rounds, MOST_ROUNDS))
        ):
            found.append({"label": label, **dataclasses.asdict(one)})
        tell(number / len(chosen))
    return found
