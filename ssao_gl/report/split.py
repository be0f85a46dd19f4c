"""Where the error comes from: the model, its sampling, the filter.

model: RMSE of the exhaustive screen-space reference against rays: what a depth buffer does not hold, and no number of
taps will mend. sampling: of the unfiltered picture against the reference. filter: of the filtered picture against the
unfiltered one without its noise (the mean over seeds). The three are no sum: parts of them cancel.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ..methods.reference import Reference
from ..pipeline import Settings
from ..settings import limits
from .setup import F32, Setup

SEEDS = 4
"""Patterns over which the noise of an unfiltered picture is averaged away."""


def reference(setup: Setup) -> F32:
    """Visibility of the exhaustive reference, unfiltered."""
    return setup.draw(Settings(method=Reference(), blur=None))


def split(setup: Setup, screen: F32, settings: Settings) -> dict[str, Any]:
    """The three parts for a method; ``screen`` is the reference's picture."""
    bare = dataclasses.replace(settings, blur=None)
    raw = setup.draw(bare)
    patterns = [setup.draw(one) for one in _seeded(bare)] or [raw]
    expected = np.mean(patterns, 0)
    final = setup.draw(settings)
    truth = setup.truth.visibility
    return {
        "model": setup.rmse(screen, truth),
        "sampling": setup.rmse(raw, screen),
        "estimator": setup.rmse(expected, screen),
        "filter": setup.rmse(final, expected),
        "raw": setup.rmse(raw, truth),
        "final": setup.rmse(final, truth),
    }


def _seeded(settings: Settings) -> list[Settings]:
    """The same under other seeds; none for a method without."""
    fields = {field.name: field for field in dataclasses.fields(settings.method)}  # type: ignore[arg-type]
    if "seed" not in fields:
        return []
    top = limits(fields["seed"]).high
    seeds = [seed for seed in range(SEEDS) if top is None or seed <= top]
    return [
        dataclasses.replace(settings, method=dataclasses.replace(settings.method, seed=seed))  # type: ignore[type-var]
        for seed in seeds
    ]
