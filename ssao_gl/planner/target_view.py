"""What is planned for: a scene, or somebody's arrays, drawn with any settings at any size."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..graph.names import DEPTH, IMAGE, NORMAL, VISIBILITY
from ..graph.plan import Plan
from ..graph.regions import DrawRegion
from ..pipeline.build import EYE_DEPTH, WINDOW_DEPTH, plan_apply
from ..pipeline.frame_setup import frame_setup
from ..pipeline.settings import Settings
from ..render.arrays import check_arrays, radius_of, settled_depth
from ..render.picture import Picture
from ..render.upsampled import needs_upsampling
from ..scene.camera import Camera
from ..scene.depth_image import DepthImage
from ..scene.model import Scene
from ..scene.projection import Size

if TYPE_CHECKING:
    from ..render.renderer import Renderer


@dataclass(frozen=True)
class PlanTarget:
    """What is to be drawn: a scene, or somebody's depth."""

    draw: Callable[[Settings, int, Sequence[str], int], Picture]
    """With settings, so many times smaller, with some AOVs, timed so many times."""
    plan: Callable[[Settings], tuple[Plan, DrawRegion]]
    """What the frame of some settings is drawn by, and which part of it is drawn."""
    camera: Camera
    size: Size
    radius: float
    layers: int


def of_scene(
    renderer: Renderer, scene: Scene, camera: Camera, size: Size, settings: Settings, aovs: Sequence[str]
) -> PlanTarget:
    """Return a scene to be rendered."""

    def draw(one: Settings, smaller: int, wanted: Sequence[str], timed: int) -> Picture:
        return renderer.render(
            scene,
            camera,
            (max(1, size[0] // smaller), max(1, size[1] // smaller)),
            one,
            aovs=wanted,
            visibility_bits=8,
            timed=timed,
        )

    def framed(one: Settings) -> tuple[Plan, DrawRegion]:
        made = frame_setup(scene, camera, size, one, renderer.ctx.max_size)
        return made.plan(aovs), made.region

    radius = settings.method.radius or camera.ao_radius or scene.default_radius()
    return PlanTarget(draw, framed, camera, size, radius, layers=2)


def of_arrays(
    renderer: Renderer,
    depth: NDArray[Any] | DepthImage,
    camera: Camera,
    settings: Settings,
    *,
    color: NDArray[Any] | None = None,
    normals: NDArray[Any] | None = None,
    depth_kind: str = EYE_DEPTH,
) -> PlanTarget:
    """Arrays that occlusion is applied to. Raises FormatError for shapes that do not fit."""
    depth, depth_kind = settled_depth(depth, depth_kind, camera)
    if needs_upsampling(color, depth, settings):
        color = None  # which is dimmed after the frame
    depth, color, normals = check_arrays(depth, color, normals)
    size = (depth.shape[1], depth.shape[0])
    outputs = (VISIBILITY, DEPTH, NORMAL, *((IMAGE,) if color is not None else ()))

    def draw(one: Settings, smaller: int, wanted: Sequence[str], timed: int) -> Picture:
        every = smaller if min(size) >= smaller else 1
        c, n = (None if a is None else np.ascontiguousarray(a[::every, ::every]) for a in (color, normals))
        d = np.ascontiguousarray(depth[::every, ::every])
        seen = d if depth_kind == WINDOW_DEPTH else DepthImage.settled(d)
        return renderer.apply(
            seen, camera, color=c, normals=n, depth_kind=depth_kind, settings=one, aovs=wanted, visibility_bits=8, timed=timed
        )

    def framed(one: Settings) -> tuple[Plan, DrawRegion]:
        made = plan_apply(one, size, depth=depth_kind, normals=normals is not None, outputs=outputs)
        return made, DrawRegion()

    radius = settings.method.radius or camera.ao_radius or radius_of(depth, camera, depth_kind)
    return PlanTarget(draw, framed, camera, size, radius, layers=1)
