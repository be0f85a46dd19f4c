"""The frame graph: passes declared as data, compiled to an immutable plan. Knows nothing of OpenGL.

Every resource name has exactly one writer. Compiling walks back from the wanted outputs, so passes that nobody
needs are culled and the order of the walk is the order of execution; transient textures whose lifetimes do not
overlap share a slot. A pass may draw on top of what another one left (``over``), and only where a depth buffer lets it
(``test``): the cheapest way not to shade a pixel on every renderer.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .errors import GraphError, near_miss

BYTES = {"r8": 1, "rgba8": 4, "rg16f": 4, "rgba16f": 8, "r32f": 4, "rgba32f": 16, "depth24": 4}
"""Bytes a pixel of each texture format; ``depth24`` is a depth buffer, which passes are tested against but never sample."""

DEPTH = "depth24"


@dataclass(frozen=True, slots=True)
class Tex:
    """A transient target: its format and its size as a share of the frame (rounded up, at least one pixel)."""

    format: str
    scale: float = 1.0

    def size(self, frame: tuple[int, int]) -> tuple[int, int]:
        w, h = (max(1, -int(-side * self.scale // 1)) for side in frame)
        return w, h


@dataclass(frozen=True, slots=True)
class Test:
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
    writes: Mapping[str, Tex]
    draw: Callable[[Any], None] = field(compare=False, repr=False)
    depth: str | None = None
    """Name of the depth buffer that it writes; it lives on when another pass is tested against it."""
    test: Test | None = None
    over: Mapping[str, str] = field(default_factory=dict)
    """Written name -> the resource it is drawn on top of, whose texture it takes over."""
    clear: tuple[float, ...] | None = None
    """What it leaves where it does not draw, in targets that are not drawn over; passes that say so draw only where there is
    something, in the part of the image that is wanted."""

    @property
    def needs(self) -> tuple[str, ...]:
        """All that must be there before it runs."""
        return (*self.reads, *self.over.values(), *((self.test.name,) if self.test else ()))


@dataclass(frozen=True, slots=True)
class Step:
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

    @property
    def bytes(self) -> int:
        return BYTES[self.format] * self.size[0] * self.size[1]


@dataclass(frozen=True, slots=True)
class Plan:
    """A compiled graph. Immutable; print it."""

    frame: tuple[int, int]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    steps: tuple[Step, ...]
    slots: tuple[Slot, ...]
    where: Mapping[str, int]
    """resource name -> index of its slot."""
    culled: Mapping[str, str]
    """pass or resource name -> the reason why it was left out."""
    unshared: int
    """Bytes the textures would take without sharing slots."""
    saved: Mapping[str, int]
    """pass or resource name -> bytes that its targets would take, had it not been culled."""

    @property
    def bytes(self) -> int:
        return sum(slot.bytes for slot in self.slots)

    def describe(self) -> str:
        """The plan as a table: what runs in which order, into what, and what was left out and why."""
        mib = 2.0**20
        lines = [
            f"{self.frame[0]}x{self.frame[1]}  inputs: {', '.join(self.inputs) or 'none'}  outputs: {', '.join(self.outputs)}"
            f"  {len(self.slots)} slots, {self.bytes / mib:.1f} MiB (unshared {self.unshared / mib:.1f})"
        ]
        width = max((len(step.task.name) for step in self.steps), default=4)
        for number, step in enumerate(self.steps, 1):
            size = f"{step.size[0]}x{step.size[1]}"
            wrote = [
                f"{name} {self.slots[slot].format} {size} -> slot {slot}"
                for name, slot in zip(step.writes, step.slots, strict=True)
            ]
            if step.task.depth is not None:
                wrote.append(f"{step.task.depth} {DEPTH} {size} -> slot {step.depth_slot}")
            reads = " ".join(step.task.reads) or "-"
            reads += f"  where {step.task.test.name} lets it" if step.task.test else ""
            lines.append(f"{number:2d} {step.task.name:{width}}  reads {reads}")
            lines += [f"   {'':{width}}  writes {text}" for text in wrote]
        lines += [f"   left out: {name}: {reason}" for name, reason in self.culled.items()]
        return "\n".join(lines)


def compile(
    passes: Sequence[Pass],
    frame: tuple[int, int],
    outputs: Sequence[str],
    inputs: Collection[str] = (),
    notes: Mapping[str, str] | None = None,
) -> Plan:
    """Order, cull and place. ``notes`` are reasons, by name, for what the caller itself left out.

    Raises GraphError: a name with two writers, a read that nobody writes, a cycle, an unknown format, targets of one
    pass that differ in size, a pass drawn over what is read later.
    """
    writer = _writers(passes, inputs)
    order = _walk(passes, writer, outputs, inputs)
    wanted = set(outputs).union(*(task.needs for task in order)) if order else set(outputs)
    read = {name for task in order for name in task.needs}
    last = {name: index for index, task in enumerate(order) for name in task.needs}
    last.update(dict.fromkeys(outputs, len(order)))

    slots: list[Slot] = []
    free: list[int] = []
    where: dict[str, int] = {}
    steps: list[Step] = []
    unshared = 0

    def place(slot: Slot) -> int:
        nonlocal unshared
        unshared += slot.bytes
        index = next((i for i in free if slots[i] == slot), None)
        if index is None:
            slots.append(slot)
            return len(slots) - 1
        free.remove(index)
        return index

    for index, task in enumerate(order):
        live = tuple(name for name in task.writes if name in wanted)
        size, scale = _target_size(task, frame), round(1 / next(iter(task.writes.values())).scale)
        for name in live:
            under = task.over.get(name)
            if under is not None:
                _check_over(task, name, under, slots[where[under]], size, last[under] > index)
            where[name] = place(Slot(task.writes[name].format, size)) if under is None else where[under]
        if task.depth is not None:
            where[task.depth] = place(Slot(DEPTH, size))
        tested = task.depth or (task.test.name if task.test else None)
        final = not any(name in read for name in live)
        where_live = tuple(where[name] for name in live)
        steps.append(Step(task, live, where_live, size, scale, final, where[tested] if tested else None))
        # Freed only after the writes were placed: a pass must never read the texture it draws into.
        over = set(task.over.values())
        done = [name for name in dict.fromkeys(task.needs) if last[name] == index and name in where and name not in over]
        done += [task.depth] if task.depth is not None and task.depth not in last else []
        free += [where[name] for name in done]

    culled, saved = _culled(passes, steps, frame)
    return Plan(
        frame, tuple(inputs), tuple(outputs), tuple(steps), tuple(slots), where, {**(notes or {}), **culled}, unshared, saved
    )


def _culled(passes: Iterable[Pass], steps: Sequence[Step], frame: tuple[int, int]) -> tuple[dict[str, str], dict[str, int]]:
    """What was left out, passes and then targets of those that stay: name -> reason, name -> bytes."""
    culled, saved = {}, {}
    run = [step.task for step in steps]
    for task in passes:
        if task not in run:
            scale = next((tex.scale for tex in task.writes.values()), 1.0)
            targets = [*task.writes.values(), *([Tex(DEPTH, scale)] if task.depth else [])]
            culled[task.name] = "nothing wants what it writes"
            saved[task.name] = sum(Slot(tex.format, tex.size(frame)).bytes for tex in targets)
    for step in steps:
        for name in step.task.writes:
            if name not in step.writes:
                culled[name] = f"nothing reads it, so {step.task.name} does not write it"
                saved[name] = Slot(step.task.writes[name].format, step.size).bytes
    return culled, saved


def _check_over(task: Pass, name: str, under: str, slot: Slot, size: tuple[int, int], read_later: bool) -> None:
    wrong = (
        "somebody wants that as it was"
        if read_later
        else "it also reads that"
        if under in task.reads
        else "their formats or sizes differ"
        if slot != Slot(task.writes[name].format, size)
        else None
    )
    if wrong:
        raise GraphError(f"pass '{task.name}' draws '{name}' over '{under}', but {wrong}")


def _writers(passes: Iterable[Pass], inputs: Collection[str]) -> dict[str, Pass]:
    writer: dict[str, Pass] = {}
    names: set[str] = set()
    for task in passes:
        if task.name in names:
            raise GraphError(f"two passes are called '{task.name}'")
        names.add(task.name)
        if not task.writes:
            raise GraphError(f"pass '{task.name}' writes nothing; it must write at least one target")
        for name in (*task.over.values(), *((task.test.name,) if task.test else ())):
            if name in inputs:
                raise GraphError(f"pass '{task.name}' draws over '{name}', or is tested against it, which is the caller's")
        for name, tex in {**task.writes, **({task.depth: Tex(DEPTH)} if task.depth else {})}.items():
            if name in writer or name in inputs:
                other = f"pass '{writer[name].name}'" if name in writer else "the caller, as an input"
                raise GraphError(f"pass '{task.name}' writes '{name}', which is also written by {other}")
            if tex.format not in BYTES:
                raise GraphError(
                    f"pass '{task.name}' writes '{name}' as '{tex.format}'; formats: {', '.join(BYTES)}."
                    + near_miss(tex.format, BYTES)
                )
            writer[name] = task
    return writer


def _walk(passes: Sequence[Pass], writer: Mapping[str, Pass], outputs: Iterable[str], inputs: Collection[str]) -> list[Pass]:
    """Depth first from the outputs; a pass is listed after everything it reads."""
    order: list[Pass] = []
    open_passes: list[str] = []

    def visit(name: str, reader: str) -> None:
        if name in inputs:
            return
        task = writer.get(name)
        if task is None:
            known = [*inputs, *writer]
            raise GraphError(
                f"{reader} needs '{name}', but no pass writes it and it is not an input"
                f" (inputs: {', '.join(inputs) or 'none'}; written: {', '.join(writer) or 'none'}).{near_miss(name, known)}"
            )
        if task.name in open_passes:
            raise GraphError("passes wait for each other: " + " -> ".join([*open_passes, task.name]))
        if task in order:
            return
        open_passes.append(task.name)
        for read in task.needs:
            visit(read, f"pass '{task.name}'")
        open_passes.pop()
        order.append(task)

    for name in outputs:
        visit(name, "the caller")
    return order


def _target_size(task: Pass, frame: tuple[int, int]) -> tuple[int, int]:
    sizes = {tex.size(frame) for tex in task.writes.values()}
    if len(sizes) != 1:
        raise GraphError(f"pass '{task.name}' must write at least one target, all of one size; it has {sorted(sizes)}")
    return sizes.pop()


def _show() -> None:
    """Print the default plan."""
    import sys

    from .pipeline import Settings, plan_render

    sys.stdout.write(plan_render(Settings(), (1280, 720)).describe() + "\n")


if __name__ == "__main__":
    _show()
