"""Visibility of places by rays, in batches: interruptible, and the same bytes however it was cut, by any number of threads."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..sampling.falloff import Falloff, rho
from ..sampling.hemisphere import hemisphere_directions, sobol_points
from ..settings import title
from .blockers import DIAMETER, OFFSET, threads
from .rays import RayScene
from .store import Store
from .sums import BLOCK, Sums, blocks, rms

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
Points = Sequence[tuple[F32, F32]]
"""Origins (n, 3) in local units, and unit normals (n, 3): one pair for each point of a place."""

LEAST_BATCHES = 4
"""Before ``max_stderr`` may stop: the spread of fewer says little."""

SAVE_SECONDS = 10.0
"""Between two saves of what is traced so far: a killed process loses no more than this."""

TraceProgress = Callable[[int, int], None]
"""Called with the rays traced and the rays there will be (an estimate with ``max_stderr``)."""


class Places(Protocol):
    """Where visibility is asked for. A place is one point, or several that share its rays between them."""

    @property
    def rays(self) -> RayScene:
        """What may block."""

    def __len__(self) -> int: ...

    def points(self, at: slice) -> Points:
        """Return where the rays of the places ``at`` start, and about which normals."""


class RaySettings(Protocol):
    """What decides the rays of a place; see :class:`~ssao_gl.truth.settings.Tracing`."""

    @property
    def radius(self) -> float | None: ...
    @property
    def falloff(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def max_stderr(self) -> float | None: ...
    @property
    def batches(self) -> tuple[int, int]: ...


def gather_sums(
    places: Places, tracing: RaySettings, *, kept: Store | None = None, progress: TraceProgress | None = None
) -> Sums:
    """Trace every place. ``kept`` is where what is traced so far goes, and comes from."""
    work = TraceWork(places, tracing, local_radius(places.rays, tracing), kept, progress or (lambda done, total: None))
    saved = kept.partial() if kept is not None else None
    fits = saved is not None and len(saved["total"]) == len(places)
    sums = Sums.restored(saved) if fits and saved is not None else Sums.empty(len(places))
    if sums.parts:
        with ThreadPoolExecutor(threads()) as pool:
            work.run(sums, pool)
    return sums


def local_radius(rays: RayScene, tracing: RaySettings) -> float:
    """Return the radius in local units. Raises SettingsError when it is not settled, or so small that offsets would blur it."""
    if tracing.radius is None:
        raise SettingsError(f"{title(tracing)}.radius: must be given here")
    least = 64 * OFFSET
    if tracing.radius * rays.scale < least:
        raise SettingsError(
            f"{title(tracing)}.radius={tracing.radius:g}: too small for 32-bit rays in a scene this large; must be at least {least / rays.scale:.3g}"
        )
    return tracing.radius * rays.scale


@dataclass(frozen=True, eq=False)
class TraceWork:
    """What is to be traced, and whom to tell."""

    places: Places
    tracing: RaySettings
    radius: float
    kept: Store | None
    progress: TraceProgress

    def run(self, sums: Sums, pool: ThreadPoolExecutor) -> None:
        """Add batches to ``sums`` until there are enough. What is traced so far is kept, whatever ends it."""
        sobol_points(self.tracing.batches[0], self.tracing.seed, sums.batches)  # imports scipy: not on the clock
        before, started = sums.seconds, time.perf_counter()
        saved = started
        try:
            while (total := self._batches(sums)) > sums.batches:
                batch = sums.batches
                for index, means in self._batch(sums, batch, pool):
                    sums.parts[index] = sums.parts[index].plus(means)
                    now = time.perf_counter()
                    sums.seconds = before + now - started
                    self._tell(batch, index, total)
                    if self.kept is not None and now - saved > SAVE_SECONDS:
                        self.kept.keep(sums.saved())
                        saved = now
        except BaseException:
            if self.kept is not None:
                self.kept.keep(sums.saved())
            raise

    def _batches(self, sums: Sums) -> int:
        """How many batches there will be, as far as can be told."""
        most, limit, done = self.tracing.batches[1], self.tracing.max_stderr, sums.batches
        if limit is None:
            return most
        if done < LEAST_BATCHES or any(part.batches != done for part in sums.parts):
            return min(most, max(done + 1, LEAST_BATCHES))
        error = rms(sums.estimate()[1])
        if error <= limit:
            return done
        return int(min(most, max(done + 1, done * (error / limit) ** 2)))

    def _batch(self, sums: Sums, batch: int, pool: ThreadPoolExecutor) -> Iterator[tuple[int, F64]]:
        """(block, means of one batch) for every block that lacks it, in order, traced a few ahead."""
        samples = sobol_points(self.tracing.batches[0], self.tracing.seed, batch)
        waiting: deque[tuple[int, Future[F64]]] = deque()
        try:
            for index, at in enumerate(blocks(len(self.places))):
                if sums.parts[index].batches > batch:
                    continue
                seed = (self.tracing.seed, batch, index)
                waiting.append((index, pool.submit(means, self.places, at, self.tracing, self.radius, samples, seed)))
                if len(waiting) > 2 * threads():
                    first, future = waiting.popleft()
                    yield first, future.result()
            while waiting:
                first, future = waiting.popleft()
                yield first, future.result()
        finally:
            for _, future in waiting:
                future.cancel()

    def _tell(self, batch: int, index: int, total: int) -> None:
        pixels, length = len(self.places), self.tracing.batches[0]
        part = min((index + 1) * BLOCK, pixels)
        self.progress((batch * pixels + part) * length, total * pixels * length)


def means(places: Places, at: slice, tracing: RaySettings, radius: float, samples: F64, seed: tuple[int, int, int]) -> F64:
    """Mean visibility (n,) of the places ``at`` over one batch of samples (m, 2). ``radius``: in local units.

    The points of a place take turns: each has a run of the samples, which is stratified in itself, and together they have
    them all, scrambled alike (``seed``).
    """
    reach = np.float32(min(radius, DIAMETER))
    total = np.zeros(at.stop - at.start)
    points = places.points(at)
    for own, (origins, normals) in zip(np.array_split(samples, len(points)), points, strict=True):
        for direction in hemisphere_directions(normals, own, np.random.default_rng(seed)):
            if tracing.falloff == Falloff.HARD:
                total += places.rays.occluded(origins, direction, float(reach))
            else:
                far = places.rays.distances(origins, direction, float(reach))
                total += np.where(far < reach, rho(tracing.falloff, far / np.float32(radius)), 0)
    return 1 - total / len(samples)
