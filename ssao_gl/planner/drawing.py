"""Pictures under settings that the planner chooses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from ..pipeline.settings import Settings
from ..render.picture import Picture
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.depth_image import DepthImage
from ..scene.model import Scene
from ..scene.projection import Size
from .choice import Target
from .plan import ROUNDS, plan, plan_arrays


def render_planned(
    renderer: Renderer,
    scene: Scene,
    camera: Camera | None,
    size: Size,
    target: Target | None,
    settings: Settings | None = None,
    *,
    aovs: str | Sequence[str] = ("image", "visibility"),
    timed: int = 0,
    **options: Any,
) -> Picture:
    """Draw a scene by :meth:`ssao_gl.Renderer.render` with the settings that :func:`.plan.plan` chooses, and time it; ``options`` are its.

    Without a target: with the settings as they are.
    """
    if target is None:
        return renderer.render(scene, camera, size, settings, aovs=aovs, timed=timed, **options)
    choice = plan(renderer, scene, camera, size, target, settings, aovs=aovs)
    rounds = max(timed, ROUNDS)
    return choice.noted(renderer.render(scene, camera, size, choice.settings, aovs=aovs, timed=rounds, **options))


def apply_planned(
    renderer: Renderer,
    depth: NDArray[Any] | DepthImage,
    camera: Camera,
    target: Target | None,
    settings: Settings | None = None,
    *,
    color: NDArray[Any] | None = None,
    normals: NDArray[Any] | None = None,
    depth_kind: str = "eye",
    **options: Any,
) -> Picture:
    """Draw over arrays by :meth:`ssao_gl.Renderer.apply`, whose ``options`` these are, with the settings that are chosen.

    Without a target: with the settings as they are.
    """
    given: dict[str, Any] = {"color": color, "normals": normals, "depth_kind": depth_kind}
    if isinstance(depth, DepthImage):  # once, however many frames it is planned by
        depth, given["depth_kind"] = DepthImage.settled(depth.linear(camera)), "eye"
    if target is None:
        return renderer.apply(depth, camera, settings=settings, **given, **options)
    choice = plan_arrays(renderer, depth, camera, target, settings, **given)
    more = {**options, "timed": max(options.get("timed", 0), ROUNDS)}
    return choice.noted(renderer.apply(depth, camera, settings=choice.settings, **given, **more))
