"""From settings to a frame graph: which passes there are, and the plans that the renderer and the effect run."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ..errors import SettingsError
from ..graph.declare import DepthTest, Pass
from ..graph.frame_graph import compile
from ..graph.plan import Plan
from ..passes import composite, culling, occlusion, prepare, resolution
from ..passes.bent_normals import BENT
from ..passes.denoise import Filter, Joint
from ..scene.projection import Size
from .culling import CullingPlan, plan_culling
from .outputs import aov_resources
from .settings import PRECISIONS, Settings, Shading, small_scale

WINDOW_DEPTH, EYE_DEPTH = "window", "eye"


def _after_gbuffer(settings: Settings, left: CullingPlan, *, bent: bool) -> list[Pass]:
    """All passes to ``visibility``, and to bent normals."""
    if bent:
        _check_bent(settings)
    method, blur, scale, cover = settings.method, settings.blur, small_scale(settings), left.cover
    tile = getattr(method, "tile", 4)
    over = culling.UNTOUCHED if left.blocks else None
    if scale == 1:
        packed = blur is not None
        return [
            prepare.depth_over_far(),
            *left.blocks,
            *([culling.shade_mask(packed=packed)] if over else []),
            occlusion.occlude(
                method, packed=packed, test=DepthTest(culling.SHADE_MASK) if over else cover, over=over, bent=bent
            ),
            *_filters(blur, tile, cover, bent),
        ]
    least = getattr(method, "refine", 0.0)
    tolerance = blur.tolerance if isinstance(blur, Joint) else Joint().tolerance
    todo, seen = (
        DepthTest(culling.SHADE_MASK, equal=equal) if left.background or over else None for equal in (False, over is not None)
    )
    return [
        *left.blocks,
        resolution.downsample(scale, open_blocks=over is not None),
        occlusion.occlude(method, packed=True, scale=scale, test=todo, over=over, bent=bent),
        *(blur.small_passes(tile, scale, seen if left.background else None, bent=bent) if isinstance(blur, Joint) else []),
        resolution.upsample("small visibility" if blur else "raw", scale, tolerance, cover, least, bent=bent),
        *([occlusion.refine_missed(method, resolution.REFINE_MASK)] if least else []),
    ]


def _filters(blur: Filter | None, tile: int, cover: DepthTest | None, bent: bool) -> list[Pass]:
    """The filter's passes at full size."""
    if isinstance(blur, Joint):
        return blur.passes(tile, cover, bent=bent)
    return blur.passes(tile, cover) if blur else []


def _check_bent(settings: Settings) -> None:
    """Raises SettingsError where bent normals cannot be had."""
    if not hasattr(settings.method, "bent"):
        raise SettingsError(f"bent: {settings.method.name} does not know which directions are open; use the method bitmask")
    if settings.blur is not None and not isinstance(settings.blur, Joint):
        raise SettingsError(f"bent: the filter {settings.blur.name} is for visibility alone; use joint, or none")


def _at(precision: str, passes: Sequence[Pass]) -> list[Pass]:
    """The passes, with shaders of that precision."""
    defines = PRECISIONS[precision]

    def precise(task: Pass) -> Pass:
        return dataclasses.replace(task, draw=lambda stage: task.draw(dataclasses.replace(stage, defines=defines)))

    return [precise(task) for task in passes] if defines else list(passes)


def _notes(settings: Settings, left: CullingPlan) -> dict[str, str]:
    return ({} if settings.blur else {"blur": "switched off"}) | ({"open blocks": left.why} if left.why else {})


def plan_render(settings: Settings, size: Size, aovs: Sequence[str] = ("image",), *, triangles: int | None = None) -> Plan:
    """The plan that draws a scene. ``triangles``: how many it has, if it surrounds the camera; None if not."""
    from ..passes.gbuffer import gbuffer, layer_behind

    flat = settings.normals == "geometric"
    left = plan_culling(settings, DepthTest(prepare.COVER, far=True), size, triangles, flat_normals=flat, bent="bent" in aovs)
    passes = [
        gbuffer(settings.shading.background_rgb, geometric=settings.normals == "geometric"),
        layer_behind(),
        *_after_gbuffer(settings, left, bent="bent" in aovs),
        composite.composite(settings.shading.ambient, settings.shading.background_rgb, direct=True),
    ]
    return compile(_at(settings.precision, passes), size, aov_resources(aovs), notes=_notes(settings, left))


def plan_filter(blur: Filter, size: Size) -> Plan:
    """The plan that filters a visibility from elsewhere, the input ``given``, by the depth and normals of a scene."""
    from ..passes.gbuffer import gbuffer

    return compile(
        [gbuffer(Shading().background_rgb, geometric=True), occlusion.pack_visibility(), *blur.passes()],
        size,
        ["visibility"],
        ["given"],
    )


def plan_apply(
    settings: Settings,
    size: Size,
    *,
    depth: str = WINDOW_DEPTH,
    normals: bool = False,
    outputs: Sequence[str] = ("visibility",),
) -> Plan:
    """The plan over a caller's depth (and normals, and colour)."""
    if "z2" in settings.method.samplers.values():
        raise SettingsError(f"{settings.method.name}: two layers need a scene to draw; a depth buffer has one")
    if depth not in (WINDOW_DEPTH, EYE_DEPTH):
        raise SettingsError(f"depth kind '{depth}'; must be 'eye' (distance along the view axis) or 'window' (0 to 1)")
    # A depth buffer of the image costs more memory than its one use costs time where occlusion is drawn at a smaller size.
    cover = DepthTest(prepare.COVER) if small_scale(settings) == 1 else None
    left = plan_culling(settings, cover, size, None, flat_normals=not normals, bent=BENT in outputs)
    notes = _notes(settings, left) | ({} if normals else {"encode normals": "no normals were given: rebuilt from depth"})
    passes = [
        prepare.linearize(window=depth == WINDOW_DEPTH, cover=left.cover is not None),
        prepare.encode_normals() if normals else prepare.reconstruct_normals(),
        *_after_gbuffer(settings, left, bent=BENT in outputs),
        composite.composite(settings.shading.ambient, (0.0, 0.0, 0.0), direct=False),
    ]
    inputs = ["depth", *(["normal_xyz"] if normals else []), *(["color"] if "image" in outputs else [])]
    return compile(_at(settings.precision, passes), size, list(outputs), inputs, notes)
