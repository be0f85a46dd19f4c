"""Visibility by rays, in batches: with its standard error, interruptible, and the same bytes however it was cut."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..sampling.falloff import Falloff, rho
from ..sampling.hemisphere import hemisphere_directions, sobol_points
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size, pixel_size
from .blockers import DIAMETER, OFFSET, threads
from .rays import RayScene
from .settings import Tracing
from .store import Store, content_key, store
from .sums import BLOCK, Sums, blocks, rms
from .surface import Surface, surface

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

LEAST_BATCHES = 4
"""Before ``max_stderr`` may stop: the spread of fewer says little."""

SAVE_SECONDS = 10.0
"""Between two saves of what is traced so far: a killed process loses no more than this."""

TraceProgress = Callable[[int, int], None]
"""Called with the rays traced and the rays there will be (an estimate with ``max_stderr``)."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Traced visibility of an image, row 0 on top.

    visibility: (h, w) float32 in 0..1, background exactly 1. stderr: (h, w) float32, its standard error, from the spread
    of independently scrambled batches; background 0; of a single batch unknown, and given as its upper bound, 1/2. depth:
    (h, w) float32, distance along the view axis in scene units, 0 = background. spp: rays traced per pixel. seconds:
    spent tracing them, over all runs that had a part in it; neither Embree's tree nor the primary rays are in it.
    """

    visibility: F32
    stderr: F32
    depth: F32
    tracing: Tracing
    spp: int
    seconds: float
    cached: bool = False
    """Nothing was traced now."""

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
        return rms(self.stderr[self.covered])


def trace(
    scene: Scene,
    camera: Camera,
    size: Size,
    tracing: Tracing | None = None,
    *,
    cache: Path | None = None,
    progress: TraceProgress | None = None,
) -> Truth:
    """Ambient occlusion, or obscurance, of what ``camera`` sees in ``scene``, by rays. ``size`` is (width, height).

    cache: a folder (see :func:`ssao_gl.truth.cache.default_folder`) where the result is kept under the hash of all that
    decides it, and taken from the next time. While it is traced, what there is goes there every few seconds and on
    Ctrl-C; the same call takes it up again and gives the same bytes as one that was never cut.
    Raises SettingsError, SceneError; FormatError when the folder cannot be written.
    """
    size = pixel_size(size)
    tracing = (tracing or Tracing()).with_radius(camera.ao_radius or scene.default_radius())
    if cache is None:
        return gather(surface(scene, camera, size), tracing, progress=progress)
    kept = store(cache, content_key(scene, camera, size, tracing))
    found = kept.result()
    if found is not None:
        return Truth(**found, tracing=tracing, cached=True)
    truth = gather(surface(scene, camera, size), tracing, kept=kept, progress=progress)
    kept.finish({name: getattr(truth, name) for name in ("visibility", "stderr", "depth", "spp", "seconds")})
    return truth


def gather(seen: Surface, tracing: Tracing, *, kept: Store | None = None, progress: TraceProgress | None = None) -> Truth:
    """Visibility of a surface that is already there, with a radius that is given. See :func:`trace`.

    One surface serves many calls: other radii, falloffs, numbers of rays. ``kept`` is where what is traced so far goes.
    """
    work = TraceWork(seen, tracing, local_radius(seen.rays, tracing), kept, progress or (lambda done, total: None))
    saved = kept.partial() if kept is not None else None
    fits = saved is not None and len(saved["total"]) == len(seen.origins)
    sums = Sums.restored(saved) if fits and saved is not None else Sums.empty(len(seen.origins))
    if sums.parts:
        with ThreadPoolExecutor(threads()) as pool:
            work.run(sums, pool)
    mean, error = sums.estimate()
    spp = sums.batches * tracing.batches[0]
    return Truth(seen.image(mean, 1), seen.image(error, 0), seen.depth, tracing, spp, sums.seconds)


def local_radius(rays: RayScene, tracing: Tracing) -> float:
    """Return the radius in local units. Raises SettingsError when it is not settled, or so small that offsets would blur it."""
    if tracing.radius is None:
        raise SettingsError("truth.radius: must be given here")
    least = 64 * OFFSET
    if tracing.radius * rays.scale < least:
        raise SettingsError(
            f"truth.radius={tracing.radius:g}: too small for 32-bit rays in a scene this large; must be at least {least / rays.scale:.3g}"
        )
    return tracing.radius * rays.scale


@dataclass(frozen=True, eq=False)
class TraceWork:
    """What is to be traced, and whom to tell."""

    seen: Surface
    tracing: Tracing
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
            for index, at in enumerate(blocks(len(self.seen.origins))):
                if sums.parts[index].batches > batch:
                    continue
                random = np.random.default_rng([self.tracing.seed, batch, index])
                waiting.append((index, pool.submit(means, self.seen, at, self.tracing, self.radius, samples, random)))
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
        pixels, length = len(self.seen.origins), self.tracing.batches[0]
        part = min((index + 1) * BLOCK, pixels)
        self.progress((batch * pixels + part) * length, total * pixels * length)


def means(seen: Surface, at: slice, tracing: Tracing, radius: float, samples: F64, random: np.random.Generator) -> F64:
    """Mean visibility (n,) of the pixels ``at`` over one batch of samples (m, 2). ``radius``: in local units."""
    normals = (seen.shading if tracing.normals == "shading" else seen.normals)[at]
    origins = seen.origins[at]
    reach = np.float32(min(radius, DIAMETER))
    total = np.zeros(len(origins))
    for direction in hemisphere_directions(normals, samples, random):
        if tracing.falloff == Falloff.HARD:
            total += seen.rays.occluded(origins, direction, float(reach))
        else:
            far = seen.rays.distances(origins, direction, float(reach))
            total += np.where(far < reach, rho(tracing.falloff, far / np.float32(radius)), 0)
    return 1 - total / len(samples)
