"""Visibility of what a camera sees, by rays, with its standard error."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size, pixel_size
from .batches import TraceProgress, gather_sums
from .settings import Tracing
from .store import Store, content_key, store
from .sums import rms
from .surface import Surface, surface

F32 = NDArray[np.float32]


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
    sums = gather_sums(seen.places(tracing.normals), tracing, kept=kept, progress=progress)
    mean, error = sums.estimate()
    spp = sums.batches * tracing.batches[0]
    return Truth(seen.image(mean, 1), seen.image(error, 0), seen.depth, tracing, spp, sums.seconds)
