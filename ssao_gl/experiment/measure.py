"""Estimators in one view: their times, interleaved, and their errors."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ContextError, SsaoError
from ..truth.blockers import threads
from .estimators import Estimator, Prepared
from .timing import interleaved, summary
from .variants import BASELINE
from .view_setup import ViewSetup

F32 = NDArray[np.float32]
Tick = Callable[[], None]
_BASELINE = "\0baseline"
"""A name that no estimator has."""


@dataclass(frozen=True, slots=True)
class Timed:
    """Times of several estimators from one interleaved run, and of the baseline in the same run.

    ready: those that took part, prepared. baseline: milliseconds of the lecture's pass alone, or None in views for which it is
    not defined. refused: why an estimator takes no part here, by name.
    """

    ready: Mapping[str, Prepared]
    times: Mapping[str, dict[str, Any]]
    baseline: dict[str, Any] | None
    refused: Mapping[str, str]


def timed(setup: ViewSetup, some: Mapping[str, Estimator], rounds: int, tick: Tick = lambda: None) -> Timed:
    """Prepare every estimator of ``some``, by name, and time all of them in turns."""
    every: dict[str, Estimator] = {_BASELINE: BASELINE, **some}
    ready: dict[str, Prepared] = {}
    refused: dict[str, str] = {}
    for name, one in every.items():
        try:
            ready[name] = one.prepare(setup)
        except ContextError:
            raise
        except SsaoError as error:
            refused[name] = str(error)
    most = {name: one.most_rounds for name, one in every.items()}
    took_part = {name: one for name, one in ready.items() if name != _BASELINE}
    draws = {name: one.time for name, one in ready.items()} if took_part else {}
    runs = interleaved(draws, rounds, most=most, tick=tick)
    baseline = summary(runs[_BASELINE])["method"] if _BASELINE in runs else None
    return Timed(took_part, {name: summary(runs[name]) for name in took_part}, baseline, refused)


def errors(setup: ViewSetup, images: Iterable[F32]) -> list[dict[str, float]]:
    """Return every metric of several visibilities, on all cores."""
    ready = setup.zones, setup.truth  # made here: cached properties are not for threads
    del ready
    with ThreadPoolExecutor(threads()) as pool:
        return list(pool.map(setup.errors, images))


def machine_load() -> float | None:
    """Return how busy the machine is: the average of the last minute, as the system counts it."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None
