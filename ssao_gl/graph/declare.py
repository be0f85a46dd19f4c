"""What a frame graph is declared with: textures, depth tests, passes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from .draws import Draw

BYTES = {
    "r8": 1, "rgba8": 4, "r16f": 2, "rg16f": 4, "rgba16f": 8, "r32f": 4, "rgba32f": 16, "r32ui": 4, "rgba32ui": 16, "depth24": 4,
}  # fmt: skip
"""Bytes a texel of each format; ``depth24`` is a depth buffer, which passes are tested against but never sample."""

DEPTH_FORMAT = "depth24"

PREVIOUS = "@previous"
"""Behind the name of a resource with a history: what it held after the last frame; zeros in the first one."""

Role = Literal["gbuffer", "layer", "prepare", "cull", "occlusion", "denoise", "upsample", "shadow", "composite"]
"""What a pass is for. Reports count times by it."""


@dataclass(frozen=True, slots=True)
class Texture:
    """A target: its format and its size as a share of the frame (rounded up, at least one texel), or ``side`` x ``side`` texels.

    ``depth`` above 1: a 3-D texture of so many layers. ``lifetime`` history: what it holds can be read in the next frame, under
    its name and ``@previous``.
    """

    format: str
    scale: float = 1.0
    depth: int = 1
    lifetime: Literal["frame", "history"] = "frame"
    side: int | None = None

    def size(self, frame: tuple[int, int]) -> tuple[int, int]:
        """Return (width, height) in texels for a frame of that many pixels."""
        if self.side is not None:
            return self.side, self.side
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
    """One draw, what it is for and what it writes. More than one write means multiple render targets."""

    name: str
    role: Role
    draw: Draw
    writes: Mapping[str, Texture]
    depth: str | None = None
    """Name of the depth buffer that it writes; it lives on when another pass is tested against it."""
    test: DepthTest | None = None
    over: Mapping[str, str] = field(default_factory=dict)
    """Written name -> the resource it is drawn on top of, whose texture it takes over."""
    clear: tuple[float, ...] | None = None
    """What it leaves where it does not draw, in targets that are not drawn over; passes that say so draw only where there is
    something, in the part of the image that is wanted."""
    blend: Literal["replace", "add"] = "replace"

    def renamed(self, old: str, new: str) -> Pass:
        """Return this pass with what it writes as ``old`` under the name ``new``."""
        if old not in self.writes:
            return self
        writes = {new if name == old else name: target for name, target in self.writes.items()}
        return replace(self, writes=writes, over={new if name == old else name: under for name, under in self.over.items()})

    @property
    def reads(self) -> tuple[str, ...]:
        """The resources that it samples."""
        return tuple(self.draw.samplers.values())

    @property
    def needs(self) -> tuple[str, ...]:
        """All that must be there before it runs; the last frame's content is."""
        now = (name for name in self.reads if not name.endswith(PREVIOUS))
        return (*now, *self.over.values(), *((self.test.name,) if self.test else ()))

    @property
    def remembers(self) -> tuple[str, ...]:
        """Resources whose content of the last frame it samples."""
        return tuple(name.removesuffix(PREVIOUS) for name in self.reads if name.endswith(PREVIOUS))
