"""Draws the shots of a case for one subject, and holds each to what every picture promises."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ContextError, InputWarning
from ..pipeline.settings import Settings
from ..render.picture import Picture
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from . import finite_check
from .outcomes import NotApplicable
from .shot import Capture, Shot
from .specimen import Specimen

SIZE = (64, 48)
"""A multiple of the noise tiles, and small."""


class Broken(Exception):
    """A picture that breaks what every picture promises; ``shot`` is what was drawn."""

    def __init__(self, what: str, shot: Shot) -> None:
        super().__init__(what)
        self.shot = shot


class CaseRunner:
    """One subject on one renderer. ``first``: gives the renderer of the first provider that opens, to compare with."""

    def __init__(
        self, renderer: Renderer, subject: Specimen, size: Size = SIZE, first: Callable[[], Renderer] | None = None
    ) -> None:
        self.renderer, self.subject, self.size = renderer, subject, size
        self.first = first or (lambda: renderer)
        self.shots: list[Shot] = []
        """All that was drawn, in order."""

    def render(self, scene: Scene, camera: Camera, **options: Any) -> Capture:
        """Draw a scene; ``options`` are fields of :class:`Shot`."""
        return self.see(Shot(camera, scene, **options))

    def apply(self, depth: ArrayLike, camera: Camera, **options: Any) -> Capture:
        """Occlusion over a depth image (h, w); ``options`` are fields of :class:`Shot`."""
        return self.see(Shot(camera, depth=np.asarray(depth), **options))

    def see(self, shot: Shot, renderer: Renderer | None = None) -> Capture:
        """Draw a shot, once to see whether all is finite and once as users get it.

        Raises Broken when the picture breaks a promise, SettingsError when the method refuses the camera, NotApplicable
        when it cannot do without a scene.
        """
        if shot.size is None:
            shot = shot.but(size=self.size if shot.depth is None else shot.depth.shape[::-1])
        self.shots.append(shot)
        settings = self.subject.settings(shot)
        if shot.scene is None and settings.method.traits.needs_scene:
            one_layer = settings.method.traits.single_layer is not None
            raise NotApplicable(
                "a depth image has one layer, for which the method is another"
                if one_layer
                else "a depth image has no scene, which the method needs"
            )
        watched = dataclasses.replace(settings, method=finite_check.with_finite_check(settings.method))
        finite = self._draw(renderer, shot, watched, ("visibility",)).visibility
        picture = self._draw(renderer, shot, settings, ("visibility", "depth", "normal"))
        seen = Capture(picture.visibility, picture.depth, picture.normal)
        for what in _broken(seen, finite):
            raise Broken(what, shot)
        return seen

    def _draw(self, renderer: Renderer | None, shot: Shot, settings: Settings, aovs: tuple[str, ...]) -> Picture:
        renderer = renderer or self.renderer
        options: dict[str, Any] = {"settings": settings, "aovs": aovs, "checked": True}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", InputWarning)  # what is wrong with a shot is known
                if shot.scene is not None:
                    return renderer.render(shot.scene, shot.camera, shot.size or self.size, **options)
                assert shot.depth is not None
                return renderer.apply(shot.depth, shot.camera, normals=shot.normals, depth_kind=shot.kind, **options)
        except ContextError as error:
            raise Broken(str(error), shot) from None


def _broken(seen: Capture, finite: NDArray[np.float32]) -> list[str]:
    """Return what every picture promises, and this one does not keep."""
    promises: dict[str, NDArray[np.bool_]] = {
        "method or filter compute NaN or infinity": finite < 1,
        "visibility is not in 0..1": ~((seen.visibility >= 0) & (seen.visibility <= 1)),
        "background is not open": ~seen.surface & (seen.visibility != 1),
        "depth is negative or not finite": ~(np.isfinite(seen.depth) & (seen.depth >= 0)),
        "normals are not of unit length": seen.surface & ~(np.abs((seen.normal**2).sum(-1) - 1) < 1e-2),
    }
    return [f"{what} at {int(where.sum())} pixels" for what, where in promises.items() if where.any()]
