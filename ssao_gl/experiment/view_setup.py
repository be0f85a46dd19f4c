"""A view made ready for measuring: its scene, its truth, and pictures of it by any settings."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..gl.timer import PassTime
from ..metrics import visibility as metrics
from ..metrics.zones import Zones, zones_of
from ..pipeline.settings import Settings
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth import Surface, Tracing, Truth, surface, trace
from ..truth.batches import TraceProgress
from ..truth.rays import RayScene

F32 = NDArray[np.float32]


@dataclass(eq=False)
class ViewSetup:
    """One camera of one scene at one size. ``cache`` is the folder of traced results."""

    renderer: Renderer
    scene: Scene
    camera: Camera
    size: Size
    tracing: Tracing
    cache: Path | None
    progress: TraceProgress | None = None

    @cached_property
    def truth(self) -> Truth:
        """By rays; from the cache when it is there."""
        return trace(self.scene, self.camera, self.size, self.tracing, cache=self.cache, progress=self.progress)

    @property
    def surface(self) -> Surface:
        """Where the rays of estimators start."""
        return self._surface[0]

    @property
    def surface_ms(self) -> float:
        """What it took to make it: Embree's tree of the scene, and a primary ray a pixel."""
        return self._surface[1]

    @property
    def tree_ms(self) -> float:
        """What it took to make Embree's tree of the scene alone."""
        return self._tree[1]

    @cached_property
    def _tree(self) -> tuple[RayScene, float]:
        began = time.perf_counter()
        made = RayScene(self.scene)
        return made, 1e3 * (time.perf_counter() - began)

    @cached_property
    def _surface(self) -> tuple[Surface, float]:
        tree, tree_ms = self._tree
        began = time.perf_counter()
        made = surface(tree, self.camera, self.size)
        return made, tree_ms + 1e3 * (time.perf_counter() - began)

    @property
    def radius(self) -> float:
        """Reach of occlusion in this view, scene units: that of the truth."""
        return self.tracing.radius or self.camera.ao_radius or self.scene.default_radius()

    @cached_property
    def depth(self) -> F32:
        """(h, w) linear depth where both rays and the rasteriser see a surface, else 0."""
        drawn = self.renderer.render(self.scene, self.camera, self.size, Settings(), aovs=("depth",)).depth
        return np.where(drawn > 0, self.truth.depth, 0).astype(np.float32)

    @cached_property
    def zones(self) -> Zones:
        """Of the surface that the truth is about, by its depth and the normals about which its rays go."""
        seen = self.surface
        normals = np.zeros((*seen.depth.shape, 3))
        normals[seen.covered] = (seen.shading if self.tracing.normals == "shading" else seen.normals) @ self.camera.pose[:3, :3]
        return zones_of(seen.depth, normals, self.camera.view(self.size), self.radius, self.depth > 0)

    @property
    def stderr(self) -> F32 | None:
        """(h, w), of the truth's pixels; None where it is not known: of a single batch of rays."""
        truth = self.truth
        return truth.stderr if truth.spp > truth.tracing.batches[0] else None

    def settled(self, settings: Settings, factor: float = 1.0) -> Settings:
        """Return ``settings`` with the radius that this view gives them, times ``factor``."""
        settings = settings.with_radius(self.radius)
        if factor == 1.0:
            return settings
        return dataclasses.replace(
            settings,
            method=dataclasses.replace(settings.method, radius=settings.method.radius * factor),  # type: ignore[type-var]
        )

    def draw(self, settings: Settings) -> F32:
        """Visibility (h, w)."""
        return self.renderer.render(
            self.scene, self.camera, self.size, self.settled(settings), aovs=("visibility",), visibility_bits=8
        ).visibility

    def time(self, settings: Settings) -> Sequence[PassTime]:
        """Milliseconds of each pass of one frame."""
        return self.renderer.time(self.scene, self.camera, self.size, self.settled(settings), aovs=("visibility",))

    def errors(self, visibility: NDArray[Any]) -> dict[str, float]:
        """Every metric against the truth."""
        return metrics.measure(visibility, self.truth.visibility, self.zones, stderr=self.stderr)

    def rmse(self, one: NDArray[Any], other: NDArray[Any]) -> float:
        """Between two visibilities (h, w), on the foreground."""
        return metrics.rmse(one.astype(np.float64), other.astype(np.float64), self.depth > 0)
