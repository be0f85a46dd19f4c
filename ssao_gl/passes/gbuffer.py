"""The G-buffer: linear depth, normals and base colour of a scene, as many of them as somebody reads."""

from __future__ import annotations

from collections.abc import Sequence

from ..graph.declare import Pass, Texture
from ..graph.draws import DrawScene, Uniform, ViewValue
from ..graph.names import BAKED, COLOR, DEPTH, DEPTH_LAYER_2, LAYER_2_MASK, MATERIAL, NORMAL, SCENE_MASK, SHADING_NORMAL

SHADERS = {
    "mesh": ("gbuffer.vert", "gbuffer.frag"),
    "spheres": ("spheres.vert", "spheres.frag"),
    "volume": ("fullscreen.vert", "volume.frag"),
}
"""Vertex and fragment shader by kind of thing; what they write is in ``lib/surface.glsl``."""
NOTHING = (0.0, 0.0, 0.0, 0.0)


def gbuffer(background: Sequence[float], *, geometric: bool, material: bool = False) -> Pass:
    """Draw the frame's scene. ``background``: sRGB in 0..1.

    ``geometric``: the normals that occlusion reads are the triangles' own; shading normals are the mesh's always. material: what shines is told too.
    """
    targets = {
        DEPTH: Texture("r32f"),
        NORMAL: Texture("rg16f"),
        SHADING_NORMAL: Texture("rg16f"),
        COLOR: Texture("rgba8"),
        BAKED: Texture("r16f"),
        **({MATERIAL: Texture("rgba8")} if material else {}),
    }
    clears = dict.fromkeys(targets, NOTHING) | {COLOR: (*background, 1.0)}
    draw = DrawScene(SHADERS, clears, defines={"GEOMETRIC": 1} if geometric else {})
    return Pass("gbuffer", "gbuffer", draw, targets, depth=SCENE_MASK)


def layer_behind(gap: float, scale: int, *, front: str = DEPTH, without: Sequence[str] = ()) -> Pass:
    """Draw the linear depth of the next surface behind the first by ``gap`` scene units, 0 where there is none.

    ``scale``: pixels of the image along each side of a texel of it. ``front``: depth of the first, of all but things ``without``.
    """
    uniforms: dict[str, Uniform] = {"u_front_step": ViewValue("target_step"), "u_front_scale": float(scale), "u_gap": gap}
    draw = DrawScene(SHADERS, {DEPTH_LAYER_2: NOTHING}, {"u_front": front}, uniforms, {"BEHIND": 1}, without=tuple(without))
    return Pass("layer behind", "layer", draw, {DEPTH_LAYER_2: Texture("r32f", 1 / scale)}, depth=LAYER_2_MASK)
