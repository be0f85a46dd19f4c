"""Passes over the whole screen that prepare what methods read, and the method's own pass."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..gl.frame import Stage
from ..graph import Pass, Tex
from ..methods import Method
from ..view import View


def linearize(*, window: bool) -> Pass:
    """A caller's ``depth`` to linear ``z``; ``window`` depth is undone with the camera's projection."""

    def draw(stage: Stage) -> None:
        constants = stage.view.depth_constants if window else {}
        stage.fullscreen("linearize.frag", constants, {"u_depth": "depth"}, defines={"WINDOW_DEPTH": 1} if window else {})

    return Pass("linearize", ("depth",), {"z": Tex("r32f")}, draw)


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


def occlusion(method: Method, *, packed: bool) -> Pass:
    """The method itself. ``packed`` hands visibility and depth in one texel to a blur, else it is the final visibility."""
    defines = {**method.defines(), **({"PACKED": 1} if packed else {})}
    lookups = method.lookups()
    seen: list[tuple[View, Mapping[str, Any]]] = []

    def draw(stage: Stage) -> None:
        if not seen or seen[0][0] is not stage.view:
            seen[:] = [(stage.view, method.uniforms(stage.view))]
        stage.fullscreen(method.shader, seen[0][1], method.samplers, defines=defines, lookups=lookups)

    writes = {"raw": Tex("r32f")} if packed else {"visibility": Tex("r8")}
    return Pass(method.name, tuple(method.samplers.values()), writes, draw)


def pack() -> Pass:
    """Visibility ``given`` by the caller, and depth, to the ``raw`` that filters read."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("pack.frag", {}, {"u_given": "given", "u_z": "z"}, defines={"PACKED": 1})

    return Pass("pack", ("given", "z"), {"raw": Tex("r32f")}, draw)


def composite(ambient: float, *, direct: bool) -> Pass:
    """``image``: colour times light, its ambient share dimmed by visibility. ``direct``: alpha of colour is direct light."""

    def draw(stage: Stage) -> None:
        stage.fullscreen(
            "composite.frag",
            {"u_ambient": ambient},
            {"u_color": "color", "u_visibility": "visibility"},
            defines={"DIRECT": 1} if direct else {},
        )

    return Pass("composite", ("color", "visibility"), {"image": Tex("rgba8")}, draw)
