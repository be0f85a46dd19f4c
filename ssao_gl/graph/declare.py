"""What a frame graph is declared with: textures, depth tests, passes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

BYTES = {"r8": 1, "rgba8": 4, "rg16f": 4, "rgba16f": 8, "r32f": 4, "rgba32f": 16, "depth24": 4}
"""Bytes a pixel of each texture format; ``depth24`` is a depth buffer, which passes are tested against but never sample."""

DEPTH = "depth24"


@dataclass(frozen=True, slots=True)
class Texture:
    """A transient target: its format and its size as a share of the frame (rounded up, at least one pixel)."""

    format: str
    scale: float = 1.0

    def size(self, frame: tuple[int, int]) -> tuple[int, int]:
        w, h = (max(1, -int(-side * self.scale // 1)) for side in frame)
        return w, h


@dataclass(frozen=True, slots=True)
class DepthTest:
    """Which pixels a full-screen pass draws: those nearer than its triangle in the depth buffer ``name``.

    ``far``: the triangle lies at the far plane, so that what a scene covers is drawn. Else it lies half way, for depth
    buffers that a pass wrote as a mask: 0 draws, 1 leaves out; ``equal``: what lies half way itself is drawn too.
    """

    name: str
    far: bool = False
    equal: bool = False


@dataclass(frozen=True, slots=True)
class Pass:
    """What a pass reads and writes and the one draw that does it. More than one write means multiple render targets."""

    name: str
    reads: tuple[str, ...]
    writes: Mapping[str, Texture]
    draw: Callable[[Any], None] = field(compare=False, repr=False)
    depth: str | None = None
    """Name of the depth buffer that it writes; it lives on when another pass is tested against it."""
    test: DepthTest | None = None
    over: Mapping[str, str] = field(default_factory=dict)
    """Written name -> the resource it is drawn on top of, whose texture it takes over."""
    clear: tuple[float, ...] | None = None
    """What it leaves where it does not draw, in targets that are not drawn over; passes that say so draw only where there is
    something, in the part of the image that is wanted."""

    @property
    def needs(self) -> tuple[str, ...]:
        """All that must be there before it runs."""
        return (*self.reads, *self.over.values(), *((self.test.name,) if self.test else ()))
