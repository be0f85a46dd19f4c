"""Methods as shipped, and rays at few samples: times and errors in one view."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ContextError, SsaoError
from ..gl.timer import PassTime
from ..passes.denoise import Joint
from ..pipeline.settings import Settings
from ..truth import Tracing, gather
from ..truth.rays import threads
from .fit import Scalars
from .timing import interleaved, summary
from .variants import BASELINE, Variant
from .view_setup import ViewSetup

F32 = NDArray[np.float32]
Some = Mapping[str, tuple[Variant, Settings, Scalars]]
"""What is measured, by label: a variant, its settings in a view, and what is done to its visibility afterwards."""
Tick = Callable[[], None]
YARD = "yardstick"


@dataclass(frozen=True, slots=True)
class Timed:
    """Times of several settings from one interleaved run, and of the yardstick in the same run.

    yardstick: milliseconds of the lecture's pass alone, or None in views for which it is not defined. refused: why a
    method takes no part here, by name.
    """

    times: Mapping[str, dict[str, Any]]
    yardstick: dict[str, Any] | None
    refused: Mapping[str, str]


def timed(setup: ViewSetup, settings: Mapping[str, Settings], rounds: int, tick: Tick = lambda: None) -> Timed:
    """Time every entry of ``settings``, by name."""
    refused: dict[str, str] = {}
    draws: dict[str, Callable[[], Sequence[PassTime]]] = {}
    for name, one in {YARD: BASELINE.settings, **settings}.items():
        try:
            setup.time(one)
        except ContextError:
            raise
        except SsaoError as error:
            refused[name] = str(error)
            continue
        draws[name] = lambda one=one: setup.time(one)  # type: ignore[misc]
    runs = interleaved(draws, rounds, tick=tick) if set(draws) - {YARD} else {}
    times = {name: summary(run) for name, run in runs.items() if name != YARD}
    yard = summary(runs[YARD])["method"] if YARD in runs else None
    return Timed(times, yard, refused)


def errors(setup: ViewSetup, images: Iterable[F32]) -> list[dict[str, float]]:
    """Every metric of several visibilities, on all cores."""
    ready = setup.depth, setup.truth  # made here: cached properties are not for threads
    del ready
    with ThreadPoolExecutor(threads()) as pool:
        return list(pool.map(setup.errors, images))


def rays(setup: ViewSetup, spp: int, rounds: int) -> tuple[F32, dict[str, Any]]:
    """Visibility of ``spp`` rays a pixel under the joint filter, and its time: tracing, and the filter's passes.

    Tracing is Embree's on all cores; its tree and the primary rays, which stand for the G-buffer, are not counted.
    """
    tracing = Tracing(radius=setup.radius, falloff=setup.tracing.falloff, normals=setup.tracing.normals, spp=spp, seed=1)
    runs = []
    for _ in range(rounds + 1):
        cpu = time.process_time()
        found = gather(setup.surface, tracing)
        cpu_ms = 1e3 * (time.process_time() - cpu)
        filtered, passes = setup.renderer.filter(setup.scene, setup.camera, setup.size, found.visibility, Joint())
        runs.append([PassTime("rays", 1e3 * found.seconds, "wall", cpu_ms, "occlusion"), *passes])
    return filtered, summary(runs[1:])


def machine_load() -> float | None:
    """How busy the machine is: the average of the last minute, as the system counts it."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None
