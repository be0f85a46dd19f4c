"""Things that receive no occlusion, and things that cast none: the scene's depth without them, beside that with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..graph.declare import Pass, Texture
from ..graph.draws import DrawScene, Fullscreen
from ..graph.names import (
    CASTER_DEPTH,
    CASTER_MASK,
    DEPTH,
    PIXEL_DEPTH,
    RECEIVER_DEPTH,
    RECEIVER_MASK,
    VISIBILITY,
    VISIBILITY_OF_ALL,
)  # fmt: skip
from ..methods.base import Method
from .gbuffer import NOTHING, SHADERS


def caster_depth(without: Sequence[str]) -> Pass:
    """Draw the linear depth of what casts occlusion: of all but things ``without`` shadow, by name."""
    return _depth(CASTER_DEPTH, CASTER_MASK, without)


def receiver_depth(without: Sequence[str]) -> Pass:
    """Draw the linear depth of what receives occlusion."""
    return _depth(RECEIVER_DEPTH, RECEIVER_MASK, without)


def _depth(name: str, mask: str, without: Sequence[str]) -> Pass:
    draw = DrawScene(SHADERS, {name: NOTHING}, without=tuple(without))
    return Pass(name.replace("_", " "), "layer", draw, {name: Texture("r32f")}, depth=mask)


def can_leave_out_casters(method: Method) -> bool:
    """Return whether a method looks for occluders in one texture, and for the pixel itself in another."""
    return PIXEL_DEPTH in method.samplers.values()


def among_casters(task: Pass) -> Pass:
    """Return a pass of such a method with its taps in the depth of what casts occlusion."""
    if task.role != "occlusion" or not isinstance(task.draw, Fullscreen):
        return task
    samplers = {name: CASTER_DEPTH if name == "u_z" else resource for name, resource in task.draw.samplers.items()}
    return replace(task, draw=replace(task.draw, samplers=samplers))


def open_excluded(screen: Sequence[Pass]) -> list[Pass]:
    """Return the passes of visibility, and behind them one that opens what receives no occlusion."""
    draw = Fullscreen("exclude.frag", {"u_z": DEPTH, "u_receiver_z": RECEIVER_DEPTH})
    opened = Pass(
        "exclude", "composite", draw, {VISIBILITY: Texture("r8")}, over={VISIBILITY: VISIBILITY_OF_ALL}, clear=(1.0,) * 4
    )
    return [*(task.renamed(VISIBILITY, VISIBILITY_OF_ALL) for task in screen), opened]
