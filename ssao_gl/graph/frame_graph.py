"""The frame graph: passes declared as data, compiled to an immutable plan. Knows nothing of OpenGL.

Every resource name has exactly one writer. Compiling walks back from the wanted outputs, so passes that nobody
needs are culled and the order of the walk is the order of execution; transient textures whose lifetimes do not
overlap share a slot. A pass may draw on top of what another one left (``over``), and only where a depth buffer lets it
(``test``): the cheapest way not to shade a pixel on every renderer. What the last frame left is read as ``name@previous``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

from ..errors import GraphError, near_miss
from .declare import BYTES, DEPTH_FORMAT, PREVIOUS, Pass, Texture
from .plan import Plan, PlannedPass, Slot


def compile(
    passes: Sequence[Pass],
    frame: tuple[int, int],
    outputs: Sequence[str],
    inputs: Collection[str] = (),
    notes: Mapping[str, str] | None = None,
) -> Plan:
    """Order the passes, cull what nobody needs, and place resources in slots.

    ``notes`` are reasons, by name, for what the caller itself left out. Raises GraphError: a name with two writers, a read
    that nobody writes, a cycle, an unknown format, targets of one pass that differ in size, a pass drawn over what is read
    later, the last frame's content of a resource without a history.
    """
    writer = _writers(passes, inputs)
    order = _walk(passes, writer, outputs, inputs)
    placed = _Placement(order, outputs)
    steps = [placed.step(index, task, frame) for index, task in enumerate(order)]
    culled, saved = _culled(passes, steps, frame)
    return Plan(
        frame, tuple(inputs), tuple(outputs), tuple(steps), tuple(placed.slots), placed.where, placed.history,
        {**(notes or {}), **culled}, placed.unaliased_bytes, saved,
    )  # fmt: skip


class _Placement:
    """Slots in the making, step by step."""

    def __init__(self, order: Sequence[Pass], outputs: Sequence[str]) -> None:
        self.slots: list[Slot] = []
        self.where: dict[str, int] = {}
        self.history: dict[str, tuple[int, int]] = {}
        self.unaliased_bytes = 0
        self._free: list[int] = []
        self._read = {name for task in order for name in (*task.needs, *task.remembers)}
        self._wanted = set(outputs) | self._read
        self._last = {name: index for index, task in enumerate(order) for name in task.needs}
        self._last.update(dict.fromkeys(outputs, len(order)))

    def step(self, index: int, task: Pass, frame: tuple[int, int]) -> PlannedPass:
        """Place what a pass writes, then free what it was the last to need."""
        live = tuple(name for name in task.writes if name in self._wanted)
        size, scale = _target_size(task, frame), round(1 / next(iter(task.writes.values())).scale)
        for name in live:
            self._place_target(index, task, name, size)
        if task.depth is not None:
            self.where[task.depth] = self._place(Slot(DEPTH_FORMAT, size))
        tested = task.depth or (task.test.name if task.test else None)
        final = not any(name in self._read for name in live)
        where_live = tuple(self.where[name] for name in live)
        # Freed only after the writes were placed: a pass must never read the texture it draws into.
        self._free += self._done(index, task)
        return PlannedPass(task, live, where_live, size, scale, final, self.where[tested] if tested else None)

    def _place_target(self, index: int, task: Pass, name: str, size: tuple[int, int]) -> None:
        texture, under = task.writes[name], task.over.get(name)
        slot = Slot(texture.format, size, texture.depth)
        if under is not None:
            _check_over(task, name, under, self.slots[self.where[under]], size, self._last[under] > index)
            self.where[name] = self.where[under]
        elif texture.lifetime == "history":
            pair = self._own(slot), self._own(slot)
            self.history[name] = pair
            self.where[name], self.where[name + PREVIOUS] = pair
        else:
            self.where[name] = self._place(slot)

    def _done(self, index: int, task: Pass) -> list[int]:
        kept = {*task.over.values(), *self.history}
        done = [n for n in dict.fromkeys(task.needs) if self._last[n] == index and n in self.where and n not in kept]
        done += [task.depth] if task.depth is not None and task.depth not in self._last else []
        return [self.where[name] for name in done]

    def _place(self, slot: Slot) -> int:
        index = next((i for i in self._free if self.slots[i] == slot), None)
        if index is None:
            return self._own(slot)
        self.unaliased_bytes += slot.bytes
        self._free.remove(index)
        return index

    def _own(self, slot: Slot) -> int:
        self.unaliased_bytes += slot.bytes
        self.slots.append(slot)
        return len(self.slots) - 1


def _culled(
    passes: Iterable[Pass], steps: Sequence[PlannedPass], frame: tuple[int, int]
) -> tuple[dict[str, str], dict[str, int]]:
    """Return what was left out, passes and then targets of those that stay: name -> reason, name -> bytes."""
    culled, saved = {}, {}
    run = [step.task.name for step in steps]
    for task in passes:
        if task.name not in run:
            scale = next((texture.scale for texture in task.writes.values()), 1.0)
            targets = [*task.writes.values(), *([Texture(DEPTH_FORMAT, scale)] if task.depth else [])]
            culled[task.name] = "nothing wants what it writes"
            saved[task.name] = sum(Slot(t.format, t.size(frame), t.depth).bytes for t in targets)
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
        else "only one of them has a history"
        if task.writes[name].lifetime == "history"
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
        for name, texture in {**task.writes, **({task.depth: Texture(DEPTH_FORMAT)} if task.depth else {})}.items():
            if name in writer or name in inputs:
                other = f"pass '{writer[name].name}'" if name in writer else "the caller, as an input"
                raise GraphError(f"pass '{task.name}' writes '{name}', which is also written by {other}")
            if texture.format not in BYTES:
                raise GraphError(
                    f"pass '{task.name}' writes '{name}' as '{texture.format}'; formats: {', '.join(BYTES)}."
                    + near_miss(texture.format, BYTES)
                )
            writer[name] = task
    return writer


def _walk(passes: Sequence[Pass], writer: Mapping[str, Pass], outputs: Iterable[str], inputs: Collection[str]) -> list[Pass]:
    """Depth first from the outputs; a pass is listed after everything it reads. What is read of the last frame is written in
    this one for the next, after that read."""
    order: dict[str, Pass] = {}
    open_passes: list[str] = []
    remembered: list[tuple[str, Pass]] = []

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
        if task.name in order:
            return
        open_passes.append(task.name)
        for read in task.needs:
            visit(read, f"pass '{task.name}'")
        open_passes.pop()
        order[task.name] = task
        remembered.extend((name, task) for name in task.remembers)

    for name in outputs:
        visit(name, "the caller")
    for name, reader in remembered:  # grows while it is walked
        visit(name, f"pass '{reader.name}'")
        if name in inputs or writer[name].writes.get(name, Texture("")).lifetime != "history":
            raise GraphError(f"pass '{reader.name}' reads '{name}{PREVIOUS}', but '{name}' has no history")
    return list(order.values())


def _target_size(task: Pass, frame: tuple[int, int]) -> tuple[int, int]:
    sizes = {texture.size(frame) for texture in task.writes.values()}
    if len(sizes) != 1:
        raise GraphError(f"pass '{task.name}' must write at least one target, all of one size; it has {sorted(sizes)}")
    return sizes.pop()
