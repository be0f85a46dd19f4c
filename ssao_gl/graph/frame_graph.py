"""The frame graph: passes declared as data, compiled to an immutable plan. Knows nothing of OpenGL.

Every resource name has exactly one writer. Compiling walks back from the wanted outputs, so passes that nobody
needs are culled and the order of the walk is the order of execution; transient textures whose lifetimes do not
overlap share a slot. A pass may draw on top of what another one left (``over``), and only where a depth buffer lets it
(``test``): the cheapest way not to shade a pixel on every renderer.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

from ..errors import GraphError, near_miss
from .declare import BYTES, DEPTH, Pass, Texture
from .plan import Plan, PlannedPass, Slot


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
    steps: list[PlannedPass] = []
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
        steps.append(PlannedPass(task, live, where_live, size, scale, final, where[tested] if tested else None))
        # Freed only after the writes were placed: a pass must never read the texture it draws into.
        over = set(task.over.values())
        done = [name for name in dict.fromkeys(task.needs) if last[name] == index and name in where and name not in over]
        done += [task.depth] if task.depth is not None and task.depth not in last else []
        free += [where[name] for name in done]

    culled, saved = _culled(passes, steps, frame)
    return Plan(
        frame, tuple(inputs), tuple(outputs), tuple(steps), tuple(slots), where, {**(notes or {}), **culled}, unshared, saved
    )


def _culled(
    passes: Iterable[Pass], steps: Sequence[PlannedPass], frame: tuple[int, int]
) -> tuple[dict[str, str], dict[str, int]]:
    """What was left out, passes and then targets of those that stay: name -> reason, name -> bytes."""
    culled, saved = {}, {}
    run = [step.task for step in steps]
    for task in passes:
        if task not in run:
            scale = next((tex.scale for tex in task.writes.values()), 1.0)
            targets = [*task.writes.values(), *([Texture(DEPTH, scale)] if task.depth else [])]
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
        for name, tex in {**task.writes, **({task.depth: Texture(DEPTH)} if task.depth else {})}.items():
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
