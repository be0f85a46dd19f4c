"""A compiled frame graph."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .declare import BYTES, DEPTH_FORMAT, Pass


@dataclass(frozen=True, slots=True)
class PlannedPass:
    """A pass that will run: the names it writes that somebody needs, and the slots they live in."""

    task: Pass
    writes: tuple[str, ...]
    slots: tuple[int, ...]
    size: tuple[int, int]
    scale: int
    """How many pixels of the frame a fragment stands for, along each side."""
    final: bool
    """Whether no other pass reads what it writes."""
    depth_slot: int | None
    """Of the depth buffer that it writes or is tested against."""


@dataclass(frozen=True, slots=True)
class Slot:
    """A texture (or depth buffer) that the frame owns."""

    format: str
    size: tuple[int, int]
    depth: int = 1
    """Layers of a 3-D texture."""

    @property
    def bytes(self) -> int:
        """What it takes, without a driver's padding."""
        return BYTES[self.format] * self.size[0] * self.size[1] * self.depth


@dataclass(frozen=True, slots=True)
class Attachments:
    """What a pass draws into: slots of its colours, of its depth buffer, and whether it writes that."""

    slots: tuple[int, ...]
    depth_slot: int | None
    writes_depth: bool


@dataclass(frozen=True, slots=True)
class FrameLayout:
    """The GL objects that a plan needs. Plans of one layout share them, whatever they draw."""

    frame: tuple[int, int]
    slots: tuple[Slot, ...]
    attachments: tuple[Attachments, ...]
    history: tuple[tuple[int, int], ...]
    """Pairs of slots that change places after every frame."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A compiled graph. Immutable; equal plans draw the same. Print it with :meth:`describe`."""

    frame: tuple[int, int]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    steps: tuple[PlannedPass, ...]
    slots: tuple[Slot, ...]
    where: Mapping[str, int]
    """resource name -> index of its slot."""
    history: Mapping[str, tuple[int, int]]
    """resource with a history -> its slots of this frame and of the last; they change places after every frame."""
    culled: Mapping[str, str]
    """pass or resource name -> the reason why it was left out."""
    unaliased_bytes: int
    """Bytes the textures would take without sharing slots."""
    saved: Mapping[str, int]
    """pass or resource name -> bytes that its targets would take, had it not been culled."""

    @property
    def bytes(self) -> int:
        """What its textures take."""
        return sum(slot.bytes for slot in self.slots)

    @property
    def layout(self) -> FrameLayout:
        """The GL objects that it needs."""
        attachments = (Attachments(step.slots, step.depth_slot, step.task.depth is not None) for step in self.steps)
        return FrameLayout(self.frame, self.slots, tuple(attachments), tuple(self.history.values()))

    def size_of(self, resource: str) -> tuple[int, int]:
        """Return (width, height) of a resource in texels."""
        return self.slots[self.where[resource]].size

    def describe(self) -> str:
        """Return the plan as a table: what runs in which order, into what, and what was left out and why."""
        mib = 2.0**20
        lines = [
            f"{self.frame[0]}x{self.frame[1]}  inputs: {', '.join(self.inputs) or 'none'}  outputs: {', '.join(self.outputs)}"
            f"  {len(self.slots)} slots, {self.bytes / mib:.1f} MiB (unshared {self.unaliased_bytes / mib:.1f})"
        ]
        width = max((len(step.task.name) for step in self.steps), default=4)
        for number, step in enumerate(self.steps, 1):
            size = f"{step.size[0]}x{step.size[1]}"
            wrote = [
                f"{name} {self.slots[slot].format} {size} -> slot {slot}"
                for name, slot in zip(step.writes, step.slots, strict=True)
            ]
            if step.task.depth is not None:
                wrote.append(f"{step.task.depth} {DEPTH_FORMAT} {size} -> slot {step.depth_slot}")
            reads = " ".join(step.task.reads) or "-"
            reads += f"  where {step.task.test.name} lets it" if step.task.test else ""
            lines.append(f"{number:2d} {step.task.name:{width}}  reads {reads}")
            lines += [f"   {'':{width}}  writes {text}" for text in wrote]
        lines += [f"   left out: {name}: {reason}" for name, reason in self.culled.items()]
        return "\n".join(lines)
