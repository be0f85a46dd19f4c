"""Which part of a frame a pass draws."""

from __future__ import annotations

from typing import TypedDict

from .plan import PlannedPass

MARGIN = 8
"""Pixels around the wanted part of an image in which intermediate passes draw too, so that filters have all their taps."""

Rect = tuple[int, int, int, int]
"""x, y, width, height in pixels, from the lower left."""


class DrawRegion(TypedDict):
    """Which part of a frame is drawn; see :meth:`FrameExecutor.run`."""

    inside: Rect | None
    covered: Rect | None


def drawn_rect(step: PlannedPass, inside: Rect | None, covered: Rect | None) -> Rect | None:
    """Where a pass that says what is left elsewhere has anything to draw, in pixels of its target; None: all of it."""
    if not step.task.clear or (inside is None and covered is None):
        return None
    scale = step.scale
    x0, y0, x1, y1 = 0, 0, step.size[0] * scale, step.size[1] * scale
    if inside:
        x, y, w, h = inside
        grow = 0 if step.final else MARGIN  # what later passes look at
        x0, y0, x1, y1 = x - grow, y - grow, x + w + grow, y + h + grow
    if covered:
        x, y, w, h = covered
        x0, y0, x1, y1 = max(x0, x), max(y0, y), min(x1, x + w), min(y1, y + h)
    x0, y0, x1, y1 = x0 // scale, y0 // scale, -(-x1 // scale), -(-y1 // scale)
    return x0, y0, max(x1 - x0, 0), max(y1 - y0, 0)
