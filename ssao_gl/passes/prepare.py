"""Passes over the whole screen that prepare what methods read."""

from __future__ import annotations

from ..graph.declare import Pass, Texture
from ..graph.draws import Define, Fullscreen, Uniform, ViewValue
from ..graph.names import DEPTH, DEPTH_OVER_FAR, GIVEN_DEPTH, GIVEN_NORMAL, GIVEN_VISIBILITY, NORMAL, SCENE_MASK, VISIBILITY_RAW

WINDOW_DEPTH: dict[str, Uniform] = {
    "u_depth_far": ViewValue("window_depth_far"),
    "u_depth_num": ViewValue("window_depth_num"),
    "u_depth_den": ViewValue("window_depth_den"),
}


def linearize(*, window: bool, mask: bool) -> Pass:
    """Turn a caller's depth into linear depth; ``window`` depth is undone with the camera's projection.

    ``mask``: write the mask of what is not background, too.
    """
    defines: dict[str, Define] = {**({"WINDOW_DEPTH": 1} if window else {}), **({"COVER": 1} if mask else {})}
    draw = Fullscreen("linearize.frag", {"u_depth": GIVEN_DEPTH}, WINDOW_DEPTH if window else {}, defines=defines)
    return Pass("linearize", "prepare", draw, {DEPTH: Texture("r32f")}, depth=SCENE_MASK if mask else None)


def reconstruct_normals() -> Pass:
    """Rebuild view-space normals from linear depth, each side of an edge from its own surface."""
    return Pass("normals", "prepare", Fullscreen("normals.frag", {"u_z": DEPTH}), {NORMAL: Texture("rg16f")})


def encode_normals() -> Pass:
    """Encode a caller's view-space normals as the graph holds them."""
    draw = Fullscreen("encode_normals.frag", {"u_normal_xyz": GIVEN_NORMAL})
    return Pass("encode normals", "prepare", draw, {NORMAL: Texture("rg16f")})


def depth_over_far() -> Pass:
    """Divide depth by that of the far plane, as the lecture wants it; 1 on background."""
    draw = Fullscreen("depth_over_far.frag", {"u_z": DEPTH}, {"u_far": ViewValue("far")})
    return Pass("depth over far", "prepare", draw, {DEPTH_OVER_FAR: Texture("r32f")})


def pack_visibility() -> Pass:
    """Pack a caller's visibility and the scene's depth into the texels that filters read."""
    draw = Fullscreen("pack_visibility.frag", {"u_given": GIVEN_VISIBILITY, "u_z": DEPTH}, defines={"PACKED": 1})
    return Pass("pack", "prepare", draw, {VISIBILITY_RAW: Texture("r32f")})
