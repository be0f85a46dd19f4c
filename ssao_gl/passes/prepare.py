"""Passes over the whole screen that prepare what methods read."""

from __future__ import annotations

from ..gl.executor import Stage
from ..graph.declare import Pass, Texture

COVER = "cover"
"""Depth buffer that tells what is not background."""


def linearize(*, window: bool, cover: bool) -> Pass:
    """A caller's ``depth`` to linear ``z``; ``window`` depth is undone with the camera's projection. ``cover``: and its mask."""
    defines = {**({"WINDOW_DEPTH": 1} if window else {}), **({"COVER": 1} if cover else {})}

    def draw(stage: Stage) -> None:
        stage.fullscreen("linearize.frag", stage.view.depth_constants if window else {}, {"u_depth": "depth"}, defines=defines)

    return Pass("linearize", ("depth",), {"z": Texture("r32f")}, draw, depth=COVER if cover else None)


def reconstruct_normals() -> Pass:
    """View-space ``normal`` rebuilt from ``z``, each side of an edge from its own surface."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("normals.frag", {}, {"u_z": "z"})

    return Pass("normals", ("z",), {"normal": Texture("rg16f")}, draw)


def encode_normals() -> Pass:
    """A caller's view-space ``normal_xyz`` to the encoding of the graph."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("encode_normals.frag", {}, {"u_normal_xyz": "normal_xyz"})

    return Pass("encode normals", ("normal_xyz",), {"normal": Texture("rg16f")}, draw)


def depth_over_far() -> Pass:
    """Depth as the lecture wants it: ``z / far``, 1 on background."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("over_far.frag", {"u_far": stage.view.far}, {"u_z": "z"})

    return Pass("z over far", ("z",), {"z_over_far": Texture("r32f")}, draw)
