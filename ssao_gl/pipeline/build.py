"""From settings to a frame graph: which passes there are, and the plans that the renderer and the effect run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..errors import SettingsError
from ..graph.declare import DepthTest, Pass
from ..graph.draws import Fullscreen
from ..graph.frame_graph import compile
from ..graph.names import (
    BENT_NORMAL,
    COLOR,
    FIELD,
    FIELD_COARSE,
    GIVEN_DEPTH,
    GIVEN_HISTORY,
    GIVEN_NORMAL,
    GIVEN_VISIBILITY,
    HISTORY,
    IMAGE,
    IMAGE_WITHOUT_HALO,
    LABELS,
    REFINE_MASK,
    SCENE_MASK,
    SHADE_MASK,
    VISIBILITY,
    VISIBILITY_NOW,
    VISIBILITY_OF_ALL,
    VISIBILITY_RAW,
    VISIBILITY_SCREEN,
    VISIBILITY_UNSHADED,
    VISIBILITY_UPSAMPLED,
)  # fmt: skip
from ..graph.plan import Plan
from ..methods.base import Method
from ..methods.traits import CAMERAS
from ..passes.composite import composite, toned
from ..passes.culling import shade_mask
from ..passes.denoise import Filter, FilterJob, FilterTraits
from ..passes.depth_table import TABLE_SCALE, depth_table
from ..passes.elements import add_elements
from ..passes.gbuffer import gbuffer
from ..passes.halo import paint_halo
from ..passes.labels import draw_labels
from ..passes.occlusion import occlude, refine_missed
from ..passes.prepare import depth_over_far, encode_normals, linearize, pack_visibility, reconstruct_normals
from ..passes.resolution import downsample, upsample, upsample_by_depth
from ..passes.resolve import resolve, resolved
from ..passes.temporal import Moment, averaged, in_phase
from ..scene.projection import Size, ViewConstants
from .culling import CullingPlan, plan_culling
from .exclusion import excluded, layers
from .lighting import Signals, light_before_occlusion, light_beside_occlusion, lit_image, signals_by_taps, signals_of
from .outputs import aov_resources
from .residual import check_no_scene, corrected
from .settings import PRECISIONS, Settings, drawn_filter, drawn_scale

WHITE = (1.0, 1.0, 1.0)
"""Base colour where there is no surface."""
WINDOW_DEPTH, EYE_DEPTH = "window", "eye"

FINAL = (
    VISIBILITY,
    VISIBILITY_SCREEN,
    VISIBILITY_UPSAMPLED,
    VISIBILITY_UNSHADED,
    VISIBILITY_OF_ALL,
    VISIBILITY_NOW,
    resolved(VISIBILITY),
)
"""Resources that hold the visibility of a frame at its end, one after the other in one texture."""


def plan_render(
    settings: Settings,
    size: Size,
    aovs: Sequence[str] = ("image",),
    *,
    triangles: int | None = None,
    fine: bool = False,
    moment: Moment | None = None,
) -> Plan:
    """Return the plan that draws a scene at ``size``, in pixels of the picture.

    ``triangles``: how many it has, if it surrounds the camera; None if not.

    ``fine``: visibility ends in half floats, for arrays, and not in the 8 bits of pictures. ``moment``: of a sequence whose frames are
    averaged; None: a frame by itself.

    Raises SettingsError when the method's radius is not settled, or cannot give what is asked for.
    """
    flat, many, light = settings.normals == "geometric", settings.supersample, settings.light if "image" in aovs else None
    size, wanted = (size[0] * many, size[1] * many), aov_resources(aovs)
    signals = signals_of(settings, light, bent="bent" in aovs)
    culling = plan_culling(settings, DepthTest(SCENE_MASK, far=True), size, triangles, flat_normals=flat, signals=bool(signals))
    background = settings.shading.background_rgba
    screen = corrected(settings, _visibility(settings, culling, signals), culling.mask)
    passes = [
        gbuffer(WHITE, geometric=flat, material=light is not None and light.specular > 0),
        *([draw_labels()] if LABELS in wanted else []),
        *light_before_occlusion(settings, light),
        *layers(settings),
        *_depth_table(settings, size),
        *add_elements(settings.method, drawn_scale(settings)),
        *excluded(settings, _over_frames(settings, screen, moment)),
        *_image(settings, background, direct=True, test=DepthTest(SCENE_MASK, far=True)),
        *(resolve(wanted, many) if many > 1 else []),
    ]
    passes = _toned(settings, passes)
    outputs = wanted if many == 1 else [resolved(name) for name in wanted]
    made = [FIELD, FIELD_COARSE] if "prepared" in settings.method.traits.inputs else []
    kept, given = ([HISTORY], [GIVEN_HISTORY]) if moment is not None else ([], [])
    return compile(
        _at(settings.precision, passes, fine), size, [*outputs, *kept], [*made, *given], notes=_notes(settings, culling)
    )


def plan_filter(blur: Filter, size: Size) -> Plan:
    """Return the plan that filters a visibility from elsewhere by the depth and normals of a scene."""
    passes = [gbuffer(WHITE, geometric=True), pack_visibility(), *blur.passes(FilterJob())]
    return compile(passes, size, [VISIBILITY], [GIVEN_VISIBILITY])


def plan_apply(
    settings: Settings,
    size: Size,
    *,
    depth: str = WINDOW_DEPTH,
    normals: bool = False,
    outputs: Sequence[str] = (VISIBILITY,),
    fine: bool = False,
    live: bool = False,
    moment: Moment | None = None,
) -> Plan:
    """Return the plan over a caller's depth (and normals, and colour). ``outputs``: resources. ``fine``, ``moment``: see
    :func:`plan_render`.

    ``live``: with tint and power in the image's shader in any case, so that they can change later. A method that looks at two layers looks at one. Raises SettingsError for methods that need a scene, and for an unknown
    kind of depth.
    """
    check_no_scene(settings, "apply")
    if settings.light:
        raise SettingsError("light: needs a scene to light, and arrays are lit already; use render, or light=None")
    single = settings.method.traits.single_layer
    layers = {"layer behind": "a depth buffer has one layer"} if single else {}
    settings = replace(settings, method=single) if single else settings
    if settings.method.traits.needs_scene:
        raise SettingsError(f"{settings.method.name}: needs a scene to draw; use render, or another method")
    if depth not in (WINDOW_DEPTH, EYE_DEPTH):
        raise SettingsError(f"depth kind '{depth}'; must be 'eye' (distance along the view axis) or 'window' (0 to 1)")
    signals = signals_of(settings, None, bent=BENT_NORMAL in outputs)
    # A depth buffer of the image costs more memory than its one use costs time where occlusion is drawn at a smaller size.
    mask = DepthTest(SCENE_MASK) if drawn_scale(settings) == 1 else None
    culling = plan_culling(settings, mask, size, None, flat_normals=not normals, signals=bool(signals))
    notes = (
        layers
        | _notes(settings, culling)
        | ({} if normals else {"encode normals": "no normals were given: rebuilt from depth"})
    )
    passes = [
        linearize(window=depth == WINDOW_DEPTH, mask=culling.mask is not None),
        encode_normals() if normals else reconstruct_normals(),
        *_depth_table(settings, size),
        *_over_frames(settings, _visibility(settings, culling, signals), moment),
        *_image(settings, (0.0, 0.0, 0.0, 1.0), direct=False),
    ]
    passes = _toned(settings, passes, live=live)
    inputs = [GIVEN_DEPTH, *([GIVEN_NORMAL] if normals else []), *([COLOR] if IMAGE in outputs else [])]
    kept, given = ([HISTORY], [GIVEN_HISTORY]) if moment is not None else ([], [])
    return compile(_at(settings.precision, passes, fine), size, [*outputs, *kept], [*inputs, *given], notes)


def check_camera(settings: Settings, view: ViewConstants) -> None:
    """Raise SettingsError for a camera that the method is not defined for."""
    method = settings.method
    has = {"perspective": view.pinhole, "far plane": math.isfinite(view.far)}
    for need in CAMERAS:
        if need in method.traits.cameras and not has[need]:
            raise SettingsError(f"{method.name}: {CAMERAS[need]}")


def _visibility(settings: Settings, culling: CullingPlan, signals: Signals) -> list[Pass]:
    """Return all passes from depth and normals to visibility, and to the signals beside it."""
    scale = drawn_scale(settings)
    if scale == 1:
        return _at_full_size(settings, culling, signals)
    if _depth_alone(settings):
        return _by_depth_alone(settings.method, culling, scale)
    return _at_smaller_size(settings, culling, scale, signals)


def _over_frames(settings: Settings, screen: Sequence[Pass], moment: Moment | None) -> list[Pass]:
    """Return the passes of visibility, in a sequence with noise of its phase and averaged over its frames."""
    if moment is None:
        return list(screen)
    phased = [in_phase(task, settings.method.traits.noise_tile, moment.phase) for task in screen]
    return averaged(phased, *_averaged_at(settings), moved=moment.moved)


def _averaged_at(settings: Settings) -> tuple[str, int]:
    """Return which visibility is averaged over frames, and its scale: the small one, where no more than upsampling follows."""
    scale, blur = drawn_scale(settings), drawn_filter(settings)
    if scale == 1 or _depth_alone(settings) or settings.method.traits.refine_below or settings.rays:
        return VISIBILITY, 1
    return FilterJob(scale=scale).result if blur else VISIBILITY_RAW, scale


def _depth_alone(settings: Settings) -> bool:
    """Return whether a method at a smaller size reads no normals."""
    return drawn_filter(settings) is None and "depth_table" in settings.method.traits.inputs


def _depth_table(settings: Settings, size: Size) -> list[Pass]:
    """Return the passes to the table that a method or halos read."""
    wanted = "depth_table" in settings.method.traits.inputs or settings.shading.halo > 0
    return depth_table(size, _table_scale(settings)) if wanted else []


def _table_scale(settings: Settings) -> int:
    """Return the pixels to a texel of the depth table: as many as the method has that reads it."""
    return drawn_scale(settings) if "depth_table" in settings.method.traits.inputs else TABLE_SCALE


def _image(settings: Settings, background: Sequence[float], *, direct: bool, test: DepthTest | None = None) -> list[Pass]:
    """Return the passes to the image: light, and halos where they are asked for."""
    shading = settings.shading
    result = IMAGE_WITHOUT_HALO if shading.halo else IMAGE
    if settings.light:
        plain = lit_image(settings, settings.light, background, test, result)
    else:
        plain = composite(shading.ambient, background, direct=direct, test=test, result=result)
    if not shading.halo:
        return [plain]
    scale, radius = _table_scale(settings), settings.method.radius
    return [plain, *paint_halo(shading.halo_rgba, shading.halo, shading.halo_width, radius, scale)]


def _toned(settings: Settings, passes: list[Pass], *, live: bool = False) -> list[Pass]:
    """Return the passes with tint and power in the image, where there are any, or they are to be ``live``."""
    shading = settings.shading
    return toned(passes, shading.power, shading.tint_linear) if live or shading.toned else passes


def _at_full_size(settings: Settings, culling: CullingPlan, signals: Signals) -> list[Pass]:
    method, blur, mask = settings.method, drawn_filter(settings), culling.mask
    packed = blur is not None
    unshaded = VISIBILITY_UNSHADED if culling.blocks else None
    test = DepthTest(SHADE_MASK) if unshaded else mask
    job = FilterJob(tile=method.traits.noise_tile, test=mask, signals=signals)
    return [
        depth_over_far(),
        *culling.blocks,
        *([shade_mask(packed=packed)] if unshaded else []),
        *light_beside_occlusion(settings, signals, packed=packed, test=test),
        occlude(method, packed=packed, test=test, over=unshaded, signals=signals_by_taps(settings, signals)),
        *(blur.passes(job) if blur else []),
    ]


def _at_smaller_size(settings: Settings, culling: CullingPlan, scale: int, signals: Signals) -> list[Pass]:
    method, blur = settings.method, drawn_filter(settings)
    unshaded = VISIBILITY_UNSHADED if culling.blocks else None
    masked = culling.background or unshaded is not None
    shaded = DepthTest(SHADE_MASK) if masked else None
    seen = DepthTest(SHADE_MASK, equal=unshaded is not None) if culling.background else None
    job = FilterJob(tile=method.traits.noise_tile, scale=scale, test=seen, signals=signals)
    tolerance = (blur.traits if blur else FilterTraits()).tolerance
    refine_below = method.traits.refine_below
    return [
        *culling.blocks,
        downsample(scale, open_blocks=unshaded is not None),
        *light_beside_occlusion(settings, signals, packed=True, scale=scale, test=shaded),
        occlude(method, packed=True, scale=scale, test=shaded, over=unshaded, signals=signals_by_taps(settings, signals)),
        *(blur.passes(job) if blur else []),
        upsample(job.result if blur else VISIBILITY_RAW, scale, tolerance, culling.mask, refine_below, signals=signals),
        *([refine_missed(method, REFINE_MASK)] if refine_below else []),
    ]


def _by_depth_alone(method: Method, culling: CullingPlan, scale: int) -> list[Pass]:
    """Return the passes of a method that reads the first of each ``scale`` x ``scale`` pixels, and no normals."""
    drawn = occlude(method, packed=True, scale=scale)
    return [drawn, upsample_by_depth(VISIBILITY_RAW, scale, method.radius, culling.mask)]


def _at(precision: str, passes: Sequence[Pass], fine: bool) -> list[Pass]:
    """Return the passes, with full-screen shaders of that precision; scenes are always drawn in the high one.

    ``fine``: with final visibilities, and what these are drawn on top of, in half floats.
    """

    def precise(task: Pass) -> Pass:
        if fine and any(name in FINAL and target.format == "r8" for name, target in task.writes.items()):
            targets = {n: replace(t, format="r16f") if n in FINAL and t.format == "r8" else t for n, t in task.writes.items()}
            task = replace(task, writes=targets)
        if not isinstance(task.draw, Fullscreen):
            return task
        return replace(task, draw=replace(task.draw, defines={**PRECISIONS[precision], **task.draw.defines}))

    return [precise(task) for task in passes]


def _notes(settings: Settings, culling: CullingPlan) -> dict[str, str]:
    """Return reasons for what is not in the graph at all, by the names of passes."""
    unfiltered = "switched off" if settings.blur is None else f"{settings.method.name} has no noise"
    return ({} if drawn_filter(settings) else {"blur": unfiltered}) | ({"open blocks": culling.why} if culling.why else {})
