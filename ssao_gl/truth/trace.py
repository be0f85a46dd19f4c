"""Visibility by rays, in batches: with its standard error, interruptible, and the same bytes however it was cut."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera, Size
from ..errors import SettingsError
from ..falloff import Falloff, weight
from ..picture import Picture
from ..renderer import check_size
from ..scene import Scene
from .cache import Store, content_key, stored
from .directions import directions, points
from .rays import DIAMETER, F32, F64, OFFSET, RayScene, blocks, threads
from .settings import Tracing
from .surface import Surface, surface

CHUNK = 1 << 13
"""Pixels a task: their directions stay in a core's own cache."""

LEAST_BATCHES = 4
"""Before ``max_stderr`` may stop: the spread of fewer says little."""

SAVE_SECONDS = 10.0
"""Between two saves of what is traced so far: a killed process loses no more than this."""

Progress = Callable[[int, int], None]
"""Called with the rays traced and the rays there will be (an estimate with ``max_stderr``)."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Traced visibility of an image, row 0 on top.

    visibility: (h, w) float32 in 0..1, background exactly 1. stderr: (h, w) float32, its standard error, from the spread
    of independently scrambled batches; background 0; with one batch unknown and given as its upper bound, 1/2. depth:
    (h, w) float32, distance along the view axis in scene units, 0 = background. spp: rays traced per pixel. seconds:
    spent tracing, building the tree and the primary rays left out, over all runs that had a part in it. batch: rays per
    pixel in a batch. cached: whether nothing was traced now.
    """

    visibility: F32
    stderr: F32
    depth: F32
    tracing: Tracing
    spp: int
    batch: int
    seconds: float
    cached: bool = False

    @property
    def covered(self) -> NDArray[np.bool_]:
        """(h, w), where there is a surface."""
        return self.depth > 0

    @property
    def rays(self) -> int:
        """Rays traced, primary ones not counted."""
        return int(self.covered.sum()) * self.spp

    @cached_property
    def noise(self) -> float:
        """Root mean square of the standard errors over the surface: the RMSE to expect against infinitely many rays."""
        return _rms(self.stderr[self.covered])

    def picture(self, **report: Any) -> Picture:
        """As a :class:`~ssao_gl.Picture` of visibility, stderr and depth, to be saved."""
        table = {name: getattr(self.tracing, name) for name in ("radius", "falloff", "normals", "max_stderr", "seed")}
        size = list(self.visibility.shape[::-1])
        arrays = {"visibility": self.visibility, "stderr": self.stderr, "depth": self.depth}
        return Picture(arrays, {"settings": {"truth": table | {"spp": self.spp}}, "size": size, **report})


def trace(
    scene: Scene,
    camera: Camera,
    size: Size,
    tracing: Tracing | None = None,
    *,
    cache: Path | None = None,
    progress: Progress | None = None,
) -> Truth:
    """Ambient occlusion, or obscurance, of what ``camera`` sees in ``scene``, by rays. ``size`` is (width, height).

    cache: a folder (:func:`ssao_gl.truth.cache.default_folder`) in which a result is kept under the hash of all that
    decides it, and taken from there the next time. While it is traced, what there is goes there every few seconds and on
    Ctrl-C; the same call takes it up again and gives the same bytes as one that was never cut.
    Raises SettingsError, SceneError; FormatError when the folder cannot be written.
    """
    check_size(size)
    tracing = (tracing or Tracing()).with_radius(camera.ao_radius or scene.default_radius())
    if cache is None:
        return gather(surface(scene, camera, size), tracing, progress=progress)
    with stored(cache, content_key(scene, camera, size, tracing)) as store:
        found = store.result()
        if found is not None:
            return Truth(**{**found, "tracing": tracing, "cached": True})
        truth = gather(surface(scene, camera, size), tracing, store=store, progress=progress)
        store.finish({name: getattr(truth, name) for name in ("visibility", "stderr", "depth", "spp", "batch", "seconds")})
    return truth


def gather(
    seen: Surface, tracing: Tracing, *, store: Store | None = None, progress: Progress | None = None
) -> Truth:
    """Visibility of a surface that is already there. ``tracing.radius`` must be given. ``store`` keeps what is done so far."""
    reach = _reach(seen.rays, tracing)
    length, most = tracing.batches
    sums = Sums.empty(len(seen.origins))
    if store is not None and (saved := store.partial()) is not None:
        sums.load(saved)
    run = Run(seen, tracing, reach, sums, store, progress or (lambda done, total: None))
    if len(seen.origins):
        with ThreadPoolExecutor(threads()) as pool:
            run.all(pool, length, most)
    mean, error = sums.estimate()
    batches = sums.parts[0].batches if sums.parts else most
    return Truth(
        seen.image(mean, 1), seen.image(error, 0), seen.depth, tracing, batches * length, length, sums.seconds
    )


def _reach(rays: RayScene, tracing: Tracing) -> float:
    """The radius in local units. Raises SettingsError when offsets of rays would blur it."""
    if tracing.radius is None:
        raise SettingsError("truth.radius: must be given here")
    reach = tracing.radius * rays.scale
    least = 64 * OFFSET
    if reach < least:
        raise SettingsError(
            f"truth.radius={tracing.radius:g}: too small for 32-bit rays in a scene this large; must be at least {least / rays.scale:.3g}"
        )
    return reach


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A block of pixels: batches done, sum and sum of squares of their means (n,) float64."""

    batches: int
    total: F64
    squares: F64

    def plus(self, means: F64) -> Part:
        return Part(self.batches + 1, self.total + means, self.squares + means**2)


@dataclass(eq=False)
class Sums:
    """All blocks. One is replaced by a whole new one in a single step, so an interrupt never finds half an update."""

    parts: list[Part]
    seconds: float = 0.0

    @classmethod
    def empty(cls, count: int) -> Sums:
        """Nothing traced yet, for ``count`` pixels."""
        return cls([Part(0, np.zeros(p.stop - p.start), np.zeros(p.stop - p.start)) for p in blocks(count, CHUNK)])

    def save(self) -> dict[str, Any]:
        """As arrays, for :meth:`load`."""
        parts = list(self.parts)
        return {
            "batches": np.array([p.batches for p in parts]),
            "total": np.concatenate([p.total for p in parts]),
            "squares": np.concatenate([p.squares for p in parts]),
            "seconds": self.seconds,
        }

    def load(self, saved: dict[str, Any]) -> None:
        """Go on from what :meth:`save` gave. Arrays of another shape are ignored."""
        if len(saved["batches"]) != len(self.parts) or len(saved["total"]) != sum(len(p.total) for p in self.parts):
            return
        places = blocks(len(saved["total"]), CHUNK)
        self.parts = [
            Part(int(n), saved["total"][at], saved["squares"][at]) for n, at in zip(saved["batches"], places, strict=True)
        ]
        self.seconds = float(saved["seconds"])

    def estimate(self) -> tuple[F64, F64]:
        """Mean and standard error (n,) over all pixels: ``sqrt((mean of squares - square of mean) / (batches - 1))``."""
        if not self.parts:
            return np.zeros(0), np.zeros(0)
        n = self.parts[0].batches
        mean = np.concatenate([p.total for p in self.parts]) / n
        if n == 1:
            return mean, np.full_like(mean, 0.5)
        squares = np.concatenate([p.squares for p in self.parts]) / n
        return mean, np.sqrt(np.maximum(squares - mean**2, 0) / (n - 1))


@dataclass(frozen=True, eq=False)
class Run:
    """One stretch of work, from where ``sums`` stands to the end or an interrupt."""

    seen: Surface
    tracing: Tracing
    reach: float
    sums: Sums
    store: Store | None
    progress: Progress

    def all(self, pool: ThreadPoolExecutor, length: int, most: int) -> None:
        """Trace batch after batch until there are ``most`` or their standard error is small enough."""
        before, started = self.sums.seconds, time.perf_counter()
        saved = started
        total = most
        try:
            for batch in range(min(p.batches for p in self.sums.parts), most):
                if self.tracing.max_stderr is not None and batch >= LEAST_BATCHES:
                    error = _rms(self.sums.estimate()[1]) if all(p.batches == batch for p in self.sums.parts) else np.inf
                    if error <= self.tracing.max_stderr:
                        return
                    total = int(min(most, max(batch + 1, batch * min((error / self.tracing.max_stderr) ** 2, most))))
                for index, means in self._batch(pool, batch, length):
                    self.sums.parts[index] = self.sums.parts[index].plus(means)
                    now = time.perf_counter()
                    self.sums.seconds = before + now - started
                    self.progress((batch * len(self.seen.origins) + min((index + 1) * CHUNK, len(self.seen.origins))) * length,
                                  total * len(self.seen.origins) * length)  # fmt: skip
                    if self.store is not None and now - saved > SAVE_SECONDS:
                        self.store.keep(self.sums.save())
                        saved = time.perf_counter()
        except BaseException:
            if self.store is not None:
                self.store.keep(self.sums.save())
            raise

    def _batch(self, pool: ThreadPoolExecutor, batch: int, length: int) -> Iterator[tuple[int, F64]]:
        """(block, means of one batch) of every block that lacks it, in order, traced a few ahead."""
        samples = points(length, self.tracing.seed, batch)
        waiting: deque[tuple[int, Future[F64]]] = deque()
        try:
            for index, at in enumerate(blocks(len(self.seen.origins), CHUNK)):
                if self.sums.parts[index].batches > batch:
                    continue
                random = np.random.default_rng([self.tracing.seed, batch, index])
                waiting.append((index, pool.submit(block_means, self.seen, at, self.tracing, self.reach, samples, random)))
                if len(waiting) > 2 * threads():
                    first, future = waiting.popleft()
                    yield first, future.result()
            while waiting:
                first, future = waiting.popleft()
                yield first, future.result()
        finally:
            for _, future in waiting:
                future.cancel()


def block_means(
    seen: Surface, at: slice, tracing: Tracing, reach: float, samples: F64, random: np.random.Generator
) -> F64:
    """Mean visibility (n,) of the pixels ``at`` over one batch of directions. ``reach``: the radius in local units."""
    normals = (seen.normals if tracing.normals == "geometric" else seen.shading)[at]
    origins = seen.origins[at]
    cut = min(reach, DIAMETER)
    total = np.zeros(len(origins))
    if tracing.falloff == Falloff.HARD:
        blocked = np.zeros(len(origins), np.int32)
        for direction in directions(normals, samples, random):
            blocked += seen.rays.occluded(origins, direction, cut)
        total += blocked
    else:
        for direction in directions(normals, samples, random):
            far = seen.rays.distances(origins, direction, cut)
            total += np.where(far < np.float32(cut), weight(tracing.falloff, far / np.float32(reach)), 0)
    return 1 - total / len(samples)


def _rms(values: NDArray[np.floating]) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64)))) if values.size else 0.0


__all__ = ["Truth", "block_means", "gather", "replace", "trace"]
