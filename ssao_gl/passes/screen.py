"""Passes over the whole screen that prepare what methods read, and the method's own pass."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from ..gl.frame import Stage
from ..graph import Pass, Test, Tex
from ..methods import Method
from ..sources import Define
from ..view import View
from .bent import beside

PIXEL = {
    False: {"u_pixel_z": "z", "u_pixel_normal": "normal"},
    True: {"u_pixel_z": "small z", "u_pixel_normal": "small normal"},
}
"""Where methods that can be drawn at a smaller size find the pixel itself."""

COVER = "cover"
"""Depth buffer that tells what is not background."""


def linearize(*, window: bool, cover: bool) -> Pass:
    """A caller's ``depth`` to linear ``z``; ``window`` depth is undone with the camera's projection. ``cover``: and its mask."""
    defines = {**({"WINDOW_DEPTH": 1} if window else {}), **({"COVER": 1} if cover else {})}

    def draw(stage: Stage) -> None:
        stage.fullscreen("linearize.frag", stage.view.depth_constants if window else {}, {"u_depth": "depth"}, defines=defines)

    return Pass("linearize", ("depth",), {"z": Tex("r32f")}, draw, depth=COVER if cover else None)


def normals_from_depth() -> Pass:
    """View-space ``normal`` rebuilt from ``z``, each side of an edge from its own surface."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("normals.frag", {}, {"u_z": "z"})

    return Pass("normals", ("z",), {"normal": Tex("rg16f")}, draw)


def encode_normals() -> Pass:
    """A caller's view-space ``normal_xyz`` to the encoding of the graph."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("encode_normals.frag", {}, {"u_normal_xyz": "normal_xyz"})

    return Pass("encode normals", ("normal_xyz",), {"normal": Tex("rg16f")}, draw)


def over_far() -> Pass:
    """Depth as the lecture wants it: ``z / far``, 1 on background."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("over_far.frag", {"u_far": stage.view.far}, {"u_z": "z"})

    return Pass("z over far", ("z",), {"z_over_far": Tex("r32f")}, draw)


def occlusion(
    method: Method, *, packed: bool, scale: int = 1, test: Test | None = None, over: str | None = None, bent: bool = False
) -> Pass:
    """The method itself. ``packed`` hands visibility and depth in one texel to a blur, else it is the final visibility.

    ``scale`` above 1: at a smaller size, for the pixels that ``shrink`` chose. ``test``: which pixels need it.
    ``over``: what holds the others' visibility, to draw on top of. ``bent``: and bent normals.
    """
    name, target = ("raw", Tex("r32f", 1 / scale)) if packed else ("visibility", Tex("r8"))
    more = beside(bent, None, name, scale)
    writes = {name: target, **more.writes}
    return _occlusion(method, method.name, writes, test, {name: over} if over else {}, more.defines)


def refine(method: Method, missed: str) -> Pass:
    """The method again, at full size, over what ``upsample`` left: so few pixels are not filtered, so they get more slices."""
    better = dataclasses.replace(method, slices=max(4, method.slices))  # type: ignore[type-var, attr-defined]
    return _occlusion(better, f"{method.name} refine", {"visibility": Tex("r8")}, Test(missed), {"visibility": "upsampled"})


def probe(method: Method, name: str, block: int) -> Pass:
    """``name``: the method for the pixel in the middle of each block alone, by more slices instead of a filter."""
    better = dataclasses.replace(method, slices=4, steps=6, tile=1)  # type: ignore[type-var]
    return _occlusion(better, f"{method.name} probe", {name: Tex("r8", 1 / block)}, None, {}, {"PROBE": 1})


def _occlusion(
    method: Method,
    name: str,
    writes: Mapping[str, Tex],
    test: Test | None,
    over: Mapping[str, str],
    more: Mapping[str, Define] | None = None,
) -> Pass:
    more = more or {}
    packed, probe = "raw" in writes, "PROBE" in more
    small = not probe and next(iter(writes.values())).scale < 1
    defines = {**method.defines(), **({"PACKED": 1} if packed else {}), **({"SMALL": 1} if small else {}), **more}
    samplers = {**method.samplers, **(PIXEL[small] if hasattr(method, "scale") else {})}
    lookups = {**method.lookups(), **(method.bent() if "BENT" in more else {})}  # type: ignore[attr-defined]
    seen: list[tuple[View, Mapping[str, Any]]] = []

    def draw(stage: Stage) -> None:
        if not seen or seen[0][0] is not stage.view:
            seen[:] = [(stage.view, method.uniforms(stage.view))]
        stage.fullscreen(method.shader, seen[0][1], samplers, defines=defines, lookups=lookups)

    clear = (0.0,) * 4 if packed else (1.0,) * 4  # background
    return Pass(name, tuple(samplers.values()), writes, draw, test=test, over=over, clear=None if probe else clear)


def pack() -> Pass:
    """Visibility ``given`` by the caller, and depth, to the ``raw`` that filters read."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("pack.frag", {}, {"u_given": "given", "u_z": "z"}, defines={"PACKED": 1})

    return Pass("pack", ("given", "z"), {"raw": Tex("r32f")}, draw)


def composite(ambient: float, background: Sequence[float], *, direct: bool) -> Pass:
    """``image``: colour times light, its ambient share dimmed by visibility; ``background`` (sRGB) where there is nothing.

    ``direct``: alpha of colour is direct light.
    """

    def draw(stage: Stage) -> None:
        stage.fullscreen(
            "composite.frag",
            {"u_ambient": ambient},
            {"u_color": "color", "u_visibility": "visibility"},
            defines={"DIRECT": 1} if direct else {},
        )

    return Pass("composite", ("color", "visibility"), {"image": Tex("rgba8")}, draw, clear=(*background, 1.0))
