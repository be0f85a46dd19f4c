"""The method's own pass, at full or at a smaller size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..errors import SettingsError
from ..graph.declare import DepthTest, Pass, Texture
from ..graph.draws import Define, FloatTable, Fullscreen, ViewValue, as_uniforms
from ..graph.names import (
    BENT_NORMAL,
    BOUNCE,
    DEPTH,
    DEPTH_SMALL,
    GAINED,
    NORMAL,
    NORMAL_SMALL,
    PIXEL_DEPTH,
    PIXEL_NORMAL,
    VISIBILITY,
    VISIBILITY_RAW,
    VISIBILITY_UPSAMPLED,
)  # fmt: skip
from ..methods.base import Method
from .extra_signals import extra_signals

PIXEL = {
    False: {PIXEL_DEPTH: DEPTH, PIXEL_NORMAL: NORMAL},
    True: {PIXEL_DEPTH: DEPTH_SMALL, PIXEL_NORMAL: NORMAL_SMALL},
}
"""Whether occlusion is drawn at a smaller size -> where the pixel itself is found."""

BACKGROUND = {True: (0.0,) * 4, False: (1.0,) * 4}
"""What packed and final visibility hold where nothing is drawn."""


def occlude(
    method: Method,
    *,
    packed: bool,
    scale: int = 1,
    test: DepthTest | None = None,
    over: str | None = None,
    signals: Sequence[str] = (),
) -> Pass:
    """Draw the method. ``packed`` hands visibility and depth in one texel to a filter, else it is the final visibility.

    ``scale`` above 1: at a smaller size, for the pixels that ``downsample`` chose. ``test``: which pixels need it.
    ``over``: what holds the others' visibility, to draw on top of. ``signals``: what is drawn beside visibility, see ``extra_signals``.
    """
    name, target = (VISIBILITY_RAW, Texture("r32f", 1 / scale)) if packed else (VISIBILITY, Texture("r8"))
    more = extra_signals(signals, None, name, scale)
    defines: dict[str, Define] = {**({"PACKED": 1} if packed else {}), **({"SMALL": 1} if scale > 1 else {}), **more.defines}
    draw = _draw(method, small=scale > 1, defines=defines)
    draw = _gathering(draw, scale) if GAINED in signals else draw
    writes, below = {name: target, **more.writes}, {name: over} if over else {}
    return Pass(method.name, "occlusion", draw, writes, test=test, over=below, clear=BACKGROUND[packed])


def _gathering(draw: Fullscreen, scale: int) -> Fullscreen:
    """Return the draw of a method with what its taps gather beside visibility."""
    samplers = {"u_bounce": BOUNCE, "u_normals": PIXEL[scale > 1][PIXEL_NORMAL]}
    texel = ViewValue("resource_size", scale, inverse=True, resource=BOUNCE)
    return replace(draw, samplers={**draw.samplers, **samplers}, uniforms={**draw.uniforms, "u_bounce_texel": texel})


def refine_missed(method: Method, mask: str) -> Pass:
    """Draw the method's refined variant at full size over what ``upsample`` left: so few pixels are not filtered."""
    refined = method.traits.refined
    if refined is None:
        raise SettingsError(f"{method.name}: has no refined variant")
    below = {VISIBILITY: VISIBILITY_UPSAMPLED}
    writes, test = {VISIBILITY: Texture("r8")}, DepthTest(mask)
    return Pass(f"{method.name} refine", "occlusion", _draw(refined), writes, test=test, over=below, clear=BACKGROUND[False])


def probe_blocks(method: Method, name: str, block: int) -> Pass:
    """Draw ``name``: the method's probe for the pixel in the middle of each block alone."""
    probe = method.traits.probe
    if probe is None:
        raise SettingsError(f"{method.name}: has no probe")
    return Pass(f"{method.name} probe", "occlusion", _draw(probe, defines={"PROBE": 1}), {name: Texture("r8", 1 / block)})


def _draw(method: Method, *, small: bool = False, defines: Mapping[str, Define] | None = None) -> Fullscreen:
    """Return the draw of a method with its settings; these come first, so that passes overrule them."""
    more = defines or {}
    outputs = (BENT_NORMAL,) if "BENT" in more else ()
    samplers = {uniform: PIXEL[small].get(resource, resource) for uniform, resource in method.samplers.items()}
    tables = {uniform: FloatTable.of(values) for uniform, values in method.tables(outputs).items()}
    return Fullscreen(method.shader, samplers, as_uniforms(method.constants()), tables, {**method.defines(), **more})
