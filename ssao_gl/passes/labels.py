"""Masks: which thing, instance and material a pixel shows."""

from __future__ import annotations

from ..graph.declare import Pass, Texture
from ..graph.draws import DrawScene
from ..graph.names import LABELS, LABELS_MASK
from .gbuffer import NOTHING, SHADERS


def draw_labels() -> Pass:
    """Draw the numbers of what is seen. A pass of its own: the G-buffer has the four targets that OpenGL ES promises."""
    draw = DrawScene(SHADERS, {LABELS: NOTHING})
    return Pass("labels", "gbuffer", draw, {LABELS: Texture("rgba32ui")}, depth=LABELS_MASK)
