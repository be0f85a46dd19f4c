"""How much of Embree's speed reaches a picture; ``ssao-gl truth --bench`` says it.

The same rays go through bare embreex calls, with origins and directions ready in memory, and through the tracer, which
makes them. Rounds are interleaved, so that what else the machine does hits both.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from ..sampling.hemisphere import hemisphere_directions, sobol_points
from .batches import local_radius, means
from .blockers import DIAMETER, threads
from .settings import Tracing
from .sums import blocks
from .surface import Surface

F32 = NDArray[np.float32]


def bench(seen: Surface, tracing: Tracing, *, blocks_used: int = 16, rounds: int = 5) -> dict[int, tuple[float, float]]:
    """Million rays a second by number of threads: (bare embreex, tracer), medians. One batch of evenly spread blocks."""
    length = tracing.batches[0]
    samples, radius = sobol_points(length, tracing.seed, 0), local_radius(seen.rays, tracing)
    every = list(enumerate(blocks(len(seen.origins))))
    chosen = [every[k] for k in np.unique(np.linspace(0, len(every) - 1, blocks_used).astype(int))]
    places = seen.places(tracing.normals)
    ready = [_rays(seen, at, samples, tracing.seed, index) for index, at in chosen]
    count = sum(len(hemisphere_directions) for _, hemisphere_directions in ready)
    reach = min(radius, DIAMETER)

    def bare(part: tuple[F32, F32]) -> int:
        return int(seen.rays.occluded(*part, reach).sum())

    def traced(part: tuple[int, slice]) -> int:
        index, at = part
        return round(float((1 - means(places, at, tracing, radius, samples, (tracing.seed, 0, index))).sum()) * length)

    speeds = {}
    for workers in sorted({1, threads()}):
        with ThreadPoolExecutor(workers) as pool:
            both: list[tuple[float, float]] = []
            for _ in range(rounds):
                first, blocked = _timed(lambda: sum(pool.map(bare, ready)))
                second, found = _timed(lambda: sum(pool.map(traced, chosen)))
                if blocked != found:
                    raise AssertionError(f"the rays are not the same: {blocked} and {found} hits")
                both.append((count / first / 1e6, count / second / 1e6))
        speeds[workers] = (statistics.median(b for b, _ in both), statistics.median(t for _, t in both))
    return speeds


def _rays(seen: Surface, at: slice, samples: NDArray[np.float64], seed: int, index: int) -> tuple[F32, F32]:
    """Origins and directions (n, 3) of one block and batch, as the tracer makes them, contiguous."""
    made = [d.copy() for d in hemisphere_directions(seen.normals[at], samples, np.random.default_rng([seed, 0, index]))]
    return np.tile(seen.origins[at], (len(samples), 1)), np.ascontiguousarray(np.concatenate(made))


def _timed(job: Callable[[], int]) -> tuple[float, int]:
    started = time.perf_counter()
    result = job()
    return time.perf_counter() - started, result
