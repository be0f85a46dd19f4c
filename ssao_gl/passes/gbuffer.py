"""The G-buffer: linear depth, normals and base colour of a scene, as many of them as somebody reads."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any

from ..gl.executor import Stage
from ..graph.declare import Pass, Texture
from .prepare import COVER

GL_COLOR, GL_DEPTH, GL_DEPTH_TEST = 0x1800, 0x1801, 0x0B71


def gbuffer(background: Sequence[float], *, geometric: bool) -> Pass:
    """The pass that draws a :class:`SceneBuffers`, given as the frame's context. ``background``: sRGB in 0..1.

    ``geometric``: ``normal``, which occlusion reads, is the triangle's own; ``shading_normal`` is the mesh's always.
    """
    targets = {"z": Texture("r32f"), "normal": Texture("rg16f"), "shading_normal": Texture("rg16f"), "color": Texture("rgba8")}
    clear = dict.fromkeys(targets, (0.0,) * 4) | {"color": (*background, 1.0)}

    def draw(stage: Stage) -> None:
        _draw_scene(stage, [clear[name] for name in stage.step.writes], {}, {"GEOMETRIC": 1} if geometric else {})

    return Pass("gbuffer", (), targets, draw, depth=COVER)


def layer_behind() -> Pass:
    """Linear depth ``z2`` of the surface behind the first at every pixel, 0 where there is none."""

    def draw(stage: Stage) -> None:
        stage.kit.bind(0, stage.textures["z"])
        uniforms = {"u_front": 0, "u_texel": stage.view.constants["u_texel"]}
        _draw_scene(stage, [(0.0,) * 4], uniforms, {"BEHIND": 1})

    return Pass("layer behind", ("z",), {"z2": Texture("r32f")}, draw, depth="behind")


def _draw_scene(
    stage: Stage, clear: Sequence[tuple[float, ...]], uniforms: Mapping[str, Any], defines: Mapping[str, int]
) -> None:
    """Clear the targets and draw the scene with a depth test, with some more uniforms and defines."""
    stage.target.use()
    gl = stage.kit.ctx.functions
    clear_buffer = gl("glClearBufferfv", None, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p)
    for index, color in enumerate(clear):
        clear_buffer(GL_COLOR, index, ctypes.addressof((ctypes.c_float * 4)(*color)))
    clear_buffer(GL_DEPTH, 0, ctypes.addressof(ctypes.c_float(1.0)))
    gl("glEnable", None, ctypes.c_uint)(GL_DEPTH_TEST)
    stage.context.draw(stage.view, stage.step.writes, uniforms, defines)
    gl("glDisable", None, ctypes.c_uint)(GL_DEPTH_TEST)
