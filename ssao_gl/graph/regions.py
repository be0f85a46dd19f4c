"""Which part of a frame a pass draws."""

from __future__ import annotations

from dataclasses import dataclass

from .plan import PlannedPass

MARGIN = 8
"""Pixels around the wanted part of an image in which intermediate passes draw too, so that filters have all their taps."""

Rect = tuple[int, int, int, int]
"""x, y, width, height in pixels, from the lower left."""


@dataclass(frozen=True, slots=True)
class DrawRegion:
    """Which part of a frame is drawn. None: all of it.

    image_rect: the part that is wanted; what only it needs is drawn only there. scene_rect: the part beside which there is
    nothing but background.
    """

    image_rect: Rect | None = None
    scene_rect: Rect | None = None
    pixel: int = 1
    """Side of a pixel of the picture, in those of the frame; above 1 with several samples a pixel."""

    @property
    def whole(self) -> bool:
        """Whether everything is drawn."""
        return self.image_rect is None and self.scene_rect is None

    def of(self, step: PlannedPass) -> Rect | None:
        """Return where a pass that says what is left elsewhere has anything to draw, in texels of its target; None: all of it."""
        if not step.task.clear or self.whole:
            return None
        scale = step.scale
        x0, y0, x1, y1 = 0, 0, step.size[0] * scale, step.size[1] * scale
        if self.image_rect:
            x, y, w, h = self.image_rect
            grow = 0 if step.final else MARGIN  # what later passes look at
            x0, y0, x1, y1 = x - grow, y - grow, x + w + grow, y + h + grow
        if self.scene_rect:
            x, y, w, h = self.scene_rect
            x0, y0, x1, y1 = max(x0, x), max(y0, y), min(x1, x + w), min(y1, y + h)
        x0, y0, x1, y1 = x0 // scale, y0 // scale, -(-x1 // scale), -(-y1 // scale)
        return x0, y0, max(x1 - x0, 0), max(y1 - y0, 0)

    def wanted_of(self, step: PlannedPass) -> Rect:
        """Return the part of a target that is wanted, in its texels: all of it but at the size of the frame or of the picture."""
        if self.image_rect is None or step.scale not in (1, self.pixel):
            return 0, 0, *step.size
        x, y, w, h = (value // step.scale for value in self.image_rect)
        return x, y, w, h
