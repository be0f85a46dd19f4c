"""The method's own pass, at full or at a smaller size."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..gl.executor import Stage
from ..glsl.preprocess import Define
from ..graph.declare import DepthTest, Pass, Texture
from ..methods.base import Method
from ..scene.projection import ViewConstants
from .bent_normals import extra_signal

PIXEL = {
    False: {"u_pixel_z": "z", "u_pixel_normal": "normal"},
    True: {"u_pixel_z": "small z", "u_pixel_normal": "small normal"},
}
"""Where methods that can be drawn at a smaller size find the pixel itself."""


def occlude(
    method: Method, *, packed: bool, scale: int = 1, test: DepthTest | None = None, over: str | None = None, bent: bool = False
) -> Pass:
    """The method itself. ``packed`` hands visibility and depth in one texel to a blur, else it is the final visibility.

    ``scale`` above 1: at a smaller size, for the pixels that ``shrink`` chose. ``test``: which pixels need it.
    ``over``: what holds the others' visibility, to draw on top of. ``bent``: and bent normals.
    """
    name, target = ("raw", Texture("r32f", 1 / scale)) if packed else ("visibility", Texture("r8"))
    more = extra_signal(bent, None, name, scale)
    writes = {name: target, **more.writes}
    return _occlusion(method, method.name, writes, test, {name: over} if over else {}, more.defines)


def refine_missed(method: Method, missed: str) -> Pass:
    """The method again, at full size, over what ``upsample`` left: so few pixels are not filtered, so they get more slices."""
    better = dataclasses.replace(method, slices=max(4, method.slices))  # type: ignore[type-var, attr-defined]
    return _occlusion(
        better, f"{method.name} refine", {"visibility": Texture("r8")}, DepthTest(missed), {"visibility": "upsampled"}
    )


def probe_blocks(method: Method, name: str, block: int) -> Pass:
    """``name``: the method for the pixel in the middle of each block alone, by more slices instead of a filter."""
    better = dataclasses.replace(method, slices=4, steps=6, tile=1)  # type: ignore[type-var]
    return _occlusion(better, f"{method.name} probe", {name: Texture("r8", 1 / block)}, None, {}, {"PROBE": 1})


def _occlusion(
    method: Method,
    name: str,
    writes: Mapping[str, Texture],
    test: DepthTest | None,
    over: Mapping[str, str],
    more: Mapping[str, Define] | None = None,
) -> Pass:
    more = more or {}
    packed, probe_blocks = "raw" in writes, "PROBE" in more
    small = not probe_blocks and next(iter(writes.values())).scale < 1
    defines = {**method.defines(), **({"PACKED": 1} if packed else {}), **({"SMALL": 1} if small else {}), **more}
    samplers = {**method.samplers, **(PIXEL[small] if hasattr(method, "scale") else {})}
    lookups = {**method.lookups(), **(method.bent() if "BENT" in more else {})}  # type: ignore[attr-defined]
    seen: list[tuple[ViewConstants, Mapping[str, Any]]] = []

    def draw(stage: Stage) -> None:
        if not seen or seen[0][0] is not stage.view:
            seen[:] = [(stage.view, method.uniforms(stage.view))]
        stage.fullscreen(method.shader, seen[0][1], samplers, defines=defines, lookups=lookups)

    clear = (0.0,) * 4 if packed else (1.0,) * 4  # background
    return Pass(name, tuple(samplers.values()), writes, draw, test=test, over=over, clear=None if probe_blocks else clear)


def pack_visibility() -> Pass:
    """Visibility ``given`` by the caller, and depth, to the ``raw`` that filters read."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("pack.frag", {}, {"u_given": "given", "u_z": "z"}, defines={"PACKED": 1})

    return Pass("pack", ("given", "z"), {"raw": Texture("r32f")}, draw)
