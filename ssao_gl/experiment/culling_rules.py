"""What the rules of leaving out save in a view: the default method under settings that bring each of them into force."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from ..methods.bitmask import Bitmask
from ..pipeline.settings import Settings
from .culling_savings import benchmark_rules
from .view_setup import ViewSetup

SUBJECTS: Mapping[str, Bitmask] = {
    "bitmask": Bitmask(),
    "bitmask high": Bitmask(**Bitmask.presets["high"]),
    "bitmask adaptive": Bitmask(adaptive=True),
}

MOST_VIEWS = 6
"""Up to so many views have their rules measured unless it is said otherwise."""

MOST_ROUNDS = 3


def measure_rules(setup: ViewSetup, rounds: int, tell: Callable[[float], None]) -> list[dict[str, Any]]:
    """Of each of the settings every rule that is in force, and all together, as plain values; see :class:`~ssao_gl.benchmark_rules.Saving`."""
    found = []
    for number, (label, method) in enumerate(SUBJECTS.items(), 1):
        settings = setup.settled(Settings(method=method))
        for one in benchmark_rules(
            setup.renderer, setup.scene, setup.camera, setup.size, settings, rounds=max(1, min(rounds, MOST_ROUNDS))
        ):
            found.append({"label": label, **dataclasses.asdict(one)})
        tell(number / len(SUBJECTS))
    return found
