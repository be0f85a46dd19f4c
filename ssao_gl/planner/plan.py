"""From a view and a target to settings: probe the view, predict every candidate, choose."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from ..errors import SettingsError
from ..io.cache import default_folder
from ..passes.denoise import Joint
from ..pipeline.build import EYE_DEPTH
from ..pipeline.outputs import aov_names
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.depth_image import DepthImage
from ..scene.model import Scene
from ..scene.projection import Size, pixel_size
from .calibration import calibrated, clock
from .candidates import CANDIDATES, PROBES, Candidate, chosen_from, differing
from .choice import Choice, Prediction, Target, choose, times
from .cost_model import Measured, PlannedFrame, Rates
from .error_model import predicted
from .features import ViewFeatures, view_features
from .target_view import PlanTarget, of_arrays, of_scene

if TYPE_CHECKING:
    from ..render.renderer import Renderer

SMALLER = 4
"""How many times as wide as the pictures that signs are taken from the picture is."""

ROUNDS = 3
"""Frames of the view that are timed."""

FINE, COARSE, DEEP = "bitmask high", "bitmask scale=1 steps=5", "bitmask ultra"
"""Candidates whose small pictures signs are taken from."""


def plan(
    renderer: Renderer,
    scene: Scene,
    camera: Camera | None,
    size: Size,
    target: Target,
    settings: Settings | None = None,
    *,
    aovs: str | Sequence[str] = ("image", "visibility"),
    cache: Path | None = None,
) -> Choice:
    """Return the settings to render ``scene`` with, so that frames meet ``target``. ``size`` is (width, height).

    ``settings`` give what is not chosen: light, rules of leaving out, the radius; and the method, when it is not the default one.
    ``cache``: the folder of calibrations, the platform's own by default. Draws some frames: once for each driver those of the
    calibration (seconds), and of the view a few small ones and four of full size under cheap settings.
    Raises SettingsError when nothing is predicted to meet the target, and for settings that the planner would overrule.
    """
    size, aovs = pixel_size(size), aov_names(aovs)
    given = _template(settings)
    camera = camera or (scene.cameras[0] if scene.cameras else scene.default_camera(size))
    return _planned(renderer, of_scene(renderer, scene, camera, size, given, aovs), target, given, aovs, cache)


def plan_arrays(
    renderer: Renderer,
    depth: NDArray[Any] | DepthImage,
    camera: Camera,
    target: Target,
    settings: Settings | None = None,
    *,
    color: NDArray[Any] | None = None,
    normals: NDArray[Any] | None = None,
    depth_kind: str = EYE_DEPTH,
    cache: Path | None = None,
) -> Choice:
    """Return the same for :meth:`ssao_gl.Renderer.apply`, whose arrays these are. Raises FormatError for shapes that do not
    fit."""
    given = _template(settings)
    subject = of_arrays(renderer, depth, camera, given, color=color, normals=normals, depth_kind=depth_kind)
    return _planned(renderer, subject, target, given, ("visibility", "depth", "normal"), cache)


def _template(settings: Settings | None) -> Settings:
    """Raise SettingsError for what the planner would overrule, or knows nothing of."""
    given = settings or Settings()
    chosen = differing(given.method)
    if chosen:
        raise SettingsError(f"the planner chooses the settings of {given.method.name} itself: leave out {', '.join(chosen)}")
    if given.blur != Joint():
        raise SettingsError("the planner knows its errors under the filter 'joint' as shipped: leave blur out")
    if given.normals != "geometric":
        raise SettingsError("the planner knows its errors for geometric normals: leave normals out")
    if given.rays:
        raise SettingsError("the planner knows its errors without rays: leave rays out")
    if given.light and given.light.bounces:
        raise SettingsError(
            f"the planner compares methods that know no bounced light: leave indirect={given.light.indirect} out, or use tint"
        )
    if given.supersample > 1:
        raise SettingsError("the planner knows its times for one sample a pixel: leave supersample out")
    if given.exclude:
        raise SettingsError("the planner knows its errors where all things occlude: leave exclude out")
    return given


def _planned(
    renderer: Renderer, subject: PlanTarget, target: Target, given: Settings, aovs: Sequence[str], cache: Path | None
) -> Choice:
    rates = calibrated(renderer, cache or default_folder())
    by, default = clock(renderer.ctx), Settings().method.name
    names = [] if given.method.name == default else [given.method.name]
    candidates = chosen_from(names, subject.layers)

    def settled(candidate: Candidate) -> Settings:
        return dataclasses.replace(given, method=candidate.made(subject.radius))

    def framed(candidate: Candidate) -> tuple[PlannedFrame, Rates]:
        family = CANDIDATES[candidate.name][0]
        return PlannedFrame(*subject.plan(settled(candidate)), candidate.method, family.taps(candidate)), rates[family.name]

    def timed(candidate: Candidate) -> Measured:
        frame, of_it = framed(candidate)
        return Measured.of(frame, times(subject.draw(settled(candidate), 1, aovs, ROUNDS).report["passes"], by), covered, of_it)

    shown, covered = look(subject, settled)
    usual, other = timed(CANDIDATES[PROBES[given.method.name][subject.layers - 1]][1]), None
    predictions = []
    for candidate in candidates:
        frame, of_it = framed(candidate)
        if lacks := usual.lacks(frame, of_it):  # what is left out by content at full size alone
            other = other or timed(candidate).beside(usual)
        ms = (other if other and lacks else usual).predict(frame, of_it)
        predictions.append(Prediction(candidate.name, ms, predicted(candidate.name, shown, subject.layers)))
    found = choose(predictions, target)
    considered = tuple(sorted(predictions, key=lambda p: p.ms))
    return Choice(settled(CANDIDATES[found.name][1]), target, found, considered, by)


def look(subject: PlanTarget, settled: Callable[[Candidate], Settings]) -> tuple[ViewFeatures, float]:
    """Return what small pictures of a view show, and the share of it that is not background."""
    looks = [FINE, COARSE, *([DEEP] if subject.layers > 1 else [])]
    wanted = ("visibility", "depth", "normal")
    drawn = [subject.draw(settled(CANDIDATES[name][1]), SMALLER, wanted, 0) for name in looks]
    depth, normals = drawn[0].depth, drawn[0].normal
    fine, coarse, *deep = (picture.visibility for picture in drawn)
    view = subject.camera.view((depth.shape[1], depth.shape[0]))
    return view_features(fine, coarse, deep[0] if deep else None, depth, normals, view, subject.radius), float(
        (depth > 0).mean()
    )
