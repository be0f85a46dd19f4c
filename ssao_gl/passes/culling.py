"""Blocks of pixels from which nothing can be seen that hides anything: their visibility is 1 without a tap."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..gl.executor import Stage
from ..graph.declare import Pass, Texture
from ..scene.projection import ViewConstants

BLOCK = 16
"""Side of a block, pixels."""

STEPS = 12
"""Taps to a side of all slices of a pixel from which on looking for open blocks may pay."""
TRIANGLE = 8
"""Pixels for each triangle from which on faces may fill blocks."""

UNTOUCHED = "untouched"
"""Visibility where nothing is drawn."""
SHADE_MASK = "todo"
"""Depth buffer: 0 where there is something to shade, half way where it is open, 1 on background."""
PROBE = "probe"
BOUNDS, SPREAD, OPEN = "block bounds", "block spread", "open blocks"


def bound_blocks() -> Pass:
    """What bounds the surfaces of each block from the front."""

    def draw(stage: Stage) -> None:
        stage.fullscreen(
            "bounds.frag", {}, {"u_z": "z", "u_normal": "normal"}, defines={"TARGETS": 2, "BLOCK": BLOCK, "BELOW": BLOCK + 1}
        )

    return Pass(BOUNDS, ("z", "normal"), {BOUNDS: Texture("rgba32f", 1 / BLOCK), SPREAD: Texture("rgba32f", 1 / BLOCK)}, draw)


def open_blocks(radius: float, max_radius: float) -> Pass:
    """Which blocks are open within ``radius`` (scene units), or as much of it as ``max_radius`` pixels cover."""

    def draw(stage: Stage) -> None:
        w, h = stage.step.size
        uniforms: dict[str, Any] = {
            "u_block_texel": (1 / w, 1 / h),
            "u_blocks": (float(w), float(h)),
            "u_radius": radius,
            "u_max_radius": max_radius,
            "u_pixel": smaller_side(stage.view),
        }
        stage.fullscreen("open.frag", uniforms, {"u_bounds": BOUNDS, "u_spread": SPREAD}, defines={"BLOCK": BLOCK})

    return Pass(OPEN, (BOUNDS, SPREAD), {OPEN: Texture("r8", 1 / BLOCK)}, draw)


def smaller_side(view: ViewConstants) -> float:
    """Least distance, in scene units for each unit of clip w, that moves a point by a pixel of the image."""
    return float(np.linalg.svd(2 * np.linalg.inv(view.projection[:2, :2]) / np.asarray(view.size), compute_uv=False).min())


def open_blocks_by_probe() -> Pass:
    """Which blocks are taken for open because their probe and all around it are."""

    def draw(stage: Stage) -> None:
        stage.fullscreen("probed.frag", {}, {"u_probe": PROBE})

    return Pass(OPEN, (PROBE,), {OPEN: Texture("r8", 1 / BLOCK)}, draw)


def shade_mask(*, packed: bool) -> Pass:
    """At full size: what there is to shade, and the visibility of the rest; see ``small.shrink`` for smaller sizes."""

    def draw(stage: Stage) -> None:
        samplers = {"u_z": "z", "u_open": OPEN}
        stage.fullscreen("todo.frag", per_block(stage), samplers, defines={"PACKED": 1} if packed else {})

    target, clear = (Texture("r32f"), (0.0,) * 4) if packed else (Texture("r8"), (1.0,) * 4)
    return Pass("todo", ("z", OPEN), {UNTOUCHED: target}, draw, depth=SHADE_MASK, clear=clear)


def per_block(stage: Stage) -> dict[str, tuple[float, float]]:
    """The uniform that finds the block of a pixel."""
    w, h = stage.textures[OPEN].size
    return {"u_per_block": (1 / (BLOCK * w), 1 / (BLOCK * h))}
