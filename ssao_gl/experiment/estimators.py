"""Estimators of visibility: whatever the report measures, behind one small interface.

An estimator says what it is, and prepares itself for a view. What that takes is told apart from what each frame takes.
Screen-space methods need no preparation; rays need a tree of the scene and the points where they start.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..gl.timer import PassTime
from ..passes.denoise import Joint
from ..pipeline.settings import Settings
from ..truth import Surface, Tracing, gather
from ..truth.rays import tree_bytes
from .view_setup import ViewSetup

F32 = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Preparation:
    """What is made once for a view and serves every frame of it."""

    ms: float = 0.0
    bytes: int = 0


class Prepared(Protocol):
    """An estimator that is ready to draw a view."""

    @property
    def preparation(self) -> Preparation: ...

    def draw(self) -> F32:
        """Return visibility (h, w) in 0..1, row 0 on top."""
        ...

    def time(self) -> Sequence[PassTime]:
        """Draw one frame and return what each of its passes took."""
        ...


class Estimator(Protocol):
    """Anything that yields visibility for a view. ``label`` tells it from all others, ``family`` joins what differs in effort."""

    @property
    def label(self) -> str: ...

    @property
    def family(self) -> str: ...

    @property
    def preset(self) -> str: ...

    @property
    def most_rounds(self) -> int | None:
        """Rounds of timing that are enough for it; None: as many as are asked for."""
        ...

    @property
    def realtime(self) -> bool:
        """Whether it goes by what a frame shows: no more than a renderer's buffers."""
        ...

    @property
    def pictured(self) -> bool:
        """Whether the page shows its pictures."""
        ...

    def table(self) -> Mapping[str, Any]:
        """Return its settings as plain values."""
        ...

    def prepare(self, setup: ViewSetup) -> Prepared:
        """Return it ready for a view. Raises SsaoError where it refuses it."""
        ...


@dataclass(frozen=True, slots=True)
class ScreenSpace:
    """A screen-space method with settings, drawn by the renderer. ``radius_factor``: upon the radius of each view."""

    family: str
    preset: str
    settings: Settings
    radius_factor: float = 1.0
    most_rounds = None
    realtime = True
    pictured = True

    @property
    def label(self) -> str:
        """What tables and plots call it."""
        return self.family if self.preset == DEFAULT else f"{self.family} {self.preset}"

    def table(self) -> Mapping[str, Any]:
        """Return its settings, without those of light."""
        return {key: value for key, value in self.settings.table().items() if key != "shading"}

    def prepare(self, setup: ViewSetup) -> Prepared:
        """Return it with its radius settled; a frame is drawn, so that it refuses here what it refuses."""
        settings = setup.settled(self.settings, self.radius_factor)
        setup.time(settings)
        if "prepared" not in settings.method.traits.inputs:
            return Drawn(setup, settings)
        drawn = setup.renderer.render(setup.scene, setup.camera, setup.size, settings, aovs=("visibility",))
        return Drawn(setup, settings, Preparation(**drawn.report["prepared"]))


@dataclass(frozen=True, slots=True)
class Drawn:
    """Settings that the renderer draws a view with."""

    setup: ViewSetup
    settings: Settings
    preparation: Preparation = Preparation()
    """Nothing, where programs and tables serve every scene."""

    def draw(self) -> F32:
        """Return visibility (h, w)."""
        return self.setup.draw(self.settings)

    def time(self) -> Sequence[PassTime]:
        """Return what each pass of a frame took."""
        return self.setup.time(self.settings)


@dataclass(frozen=True, slots=True)
class Rays:
    """Ray-traced occlusion of ``spp`` rays a pixel by Embree on all cores, then the joint filter."""

    spp: int
    family = "rays"
    most_rounds = 3
    realtime = False

    @property
    def preset(self) -> str:
        """Its effort."""
        return str(self.spp)

    @property
    def label(self) -> str:
        """What tables and plots call it."""
        return f"{self.family} {self.spp}"

    @property
    def pictured(self) -> bool:
        """The least and the most of them."""
        return self.spp in (RAYS[0], RAYS[-1])

    def table(self) -> Mapping[str, Any]:
        """Return its settings."""
        return {"method": self.family, "spp": self.spp, "blur": Joint.name}

    def prepare(self, setup: ViewSetup) -> Prepared:
        """Return it with the scene's tree and the primary rays, which stand for the G-buffer."""
        surface = setup.surface
        size = tree_bytes(setup.scene)
        size += sum(array.nbytes for array in (surface.origins, surface.normals, surface.shading, surface.depth))
        truth = setup.tracing
        tracing = Tracing(radius=setup.radius, falloff=truth.falloff, normals=truth.normals, spp=self.spp, seed=1)
        return _Traced(setup, surface, tracing, Preparation(setup.surface_ms, size))


@dataclass(frozen=True, slots=True)
class _Traced:
    setup: ViewSetup
    surface: Surface
    tracing: Tracing
    preparation: Preparation

    def draw(self) -> F32:
        return self._frame()[0]

    def time(self) -> Sequence[PassTime]:
        return self._frame()[1]

    def _frame(self) -> tuple[F32, Sequence[PassTime]]:
        setup, cpu = self.setup, time.process_time()
        found = gather(self.surface, self.tracing)
        cpu_ms = 1e3 * (time.process_time() - cpu)
        visibility, passes = setup.renderer.filter(setup.scene, setup.camera, setup.size, found.visibility, Joint())
        return visibility, [PassTime("rays", 1e3 * found.seconds, "wall", cpu_ms, "occlusion"), *passes]


DEFAULT = "default"
"""The preset of methods as shipped, where none of their own is that."""

RAYS = (1, 2, 4, 8)
"""Rays a pixel of the estimators that every report measures beside the methods."""
