"""What holds for frames of every size: the plan of the largest one, and below which sizes its passes have nothing to do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ..errors import GraphError
from ..graph.declare import DEPTH_FORMAT
from ..graph.draws import Fullscreen
from ..graph.plan import Plan, PlannedPass, Slot
from ..scene.projection import Size

LARGEST = 16384
"""Side of the largest frame, pixels: what most drivers draw at most."""
CHECKED: tuple[Size, ...] = ((1, 1), (7, 5), (3, 300), (300, 3), (161, 91), (90, 777), (1280, 720), (4097, 33))
"""Sizes at which the plan of the largest frame, cut down, must be the plan of that size."""

PlanAt = Callable[[Size], Plan]


@dataclass(frozen=True, slots=True)
class SizedPlan:
    """The plan of the largest frame, and from which width or height on each of its passes runs; None: never for its sake.

    A pass that does not run hands on what it samples. Passes without an entry always run.
    """

    plan: Plan
    when: Mapping[str, tuple[int | None, int | None]]

    def runs(self, step: PlannedPass, size: Size) -> bool:
        """Whether a pass has something to do in a frame of that size."""
        sides = zip(self.when.get(step.task.name, (1, 1)), size, strict=True)
        return any(least is not None and side >= least for least, side in sides)


def sized_plan(plan_at: PlanAt) -> SizedPlan:
    """Return what holds for all frames. Raises GraphError where a plan depends on the size in another way."""
    plan, smallest = plan_at((LARGEST, LARGEST)), pass_names(plan_at((1, 1)))
    when = {}
    for step in plan.steps:
        name = step.task.name
        if name not in smallest:
            when[name] = (_least(name, lambda n: plan_at((n, 1))), _least(name, lambda n: plan_at((1, n))))
            if len(step.task.reads) != 1 or len(step.writes) != 1:
                raise GraphError(f"pass '{name}' runs in some sizes only, and does not hand on one resource")
    made = SizedPlan(_unshared(plan, when), when)
    for size in CHECKED:
        _check(made, plan_at(size), size)
    return made


def pass_names(plan: Plan) -> list[str]:
    """Return the names of a plan's passes, in order."""
    return [step.task.name for step in plan.steps]


def slot_scales(plan: Plan) -> list[int]:
    """Return how many pixels of the frame a texel of each slot stands for, along each side."""
    scales: dict[int, int] = {}
    for step in plan.steps:
        for slot in (*step.slots, *([] if step.depth_slot is None else [step.depth_slot])):
            if scales.setdefault(slot, step.scale) != step.scale:
                raise GraphError(f"pass '{step.task.name}' shares a texture with one of another scale")
    return [scales[index] for index in range(len(plan.slots))]


def scaled_size(scale: int, size: Size) -> Size:
    """Return the size of a target with a texel for every ``scale`` x ``scale`` pixels."""
    w, h = (-(-side // scale) for side in size)
    return w, h


def aliases(made: SizedPlan, size: Size) -> dict[str, str]:
    """Return what passes that do not run write -> the resource that stands for it."""
    found: dict[str, str] = {}
    for step in made.plan.steps:
        if not made.runs(step, size):
            source = step.task.reads[0]
            found[step.writes[0]] = found.get(source, source)
    return found


def _least(name: str, plan_of: Callable[[int], Plan]) -> int | None:
    """Return the least side from which on a pass runs; None: there is none."""
    low, high = 1, LARGEST  # it does not run at the first, and runs at the second
    if name not in pass_names(plan_of(high)):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if name in pass_names(plan_of(middle)) else (middle, high)
    return high


def _check(made: SizedPlan, plan: Plan, size: Size) -> None:
    """Raise GraphError unless the largest plan, cut down to ``size``, is what is planned there."""
    also = aliases(made, size)
    written: dict[int, str] = {}
    steps = [step for step in made.plan.steps if made.runs(step, size)]
    if [step.task.name for step in steps] != pass_names(plan):
        raise GraphError(f"the passes of {size[0]}x{size[1]} are not those of other sizes")
    there: dict[str, str] = {}
    for step, own in zip(steps, plan.steps, strict=True):
        mine, other = step.task.draw, own.task.draw
        assert isinstance(mine, Fullscreen) and isinstance(other, Fullscreen)
        there |= dict(zip(step.writes, own.writes, strict=True))
        reads = {uniform: there.get(also.get(name, name), name) for uniform, name in mine.samplers.items()}
        same = reads == dict(other.samplers) and (mine.shader, mine.uniforms, mine.tables, mine.defines) == (
            other.shader, other.uniforms, other.tables, other.defines
        )  # fmt: skip
        fits = scaled_size(step.scale, size) == own.size and step.scale == own.scale
        if not same or not fits or any(made.plan.slots[slot].format == DEPTH_FORMAT for slot in step.slots):
            raise GraphError(f"pass '{step.task.name}' depends on the size {size[0]}x{size[1]} in a way that has no formula")
        _check_kept(step, also, made.plan, written)
        written |= dict(zip(step.slots, step.writes, strict=True))


def _check_kept(step: PlannedPass, also: Mapping[str, str], plan: Plan, written: Mapping[int, str]) -> None:
    """Raise GraphError where a pass reads what another one has drawn over since, or what it draws into itself."""
    for read in step.task.reads:
        name = also.get(read, read)
        if name in plan.where and (written.get(plan.where[name]) != name or plan.where[name] in step.slots):
            raise GraphError(f"pass '{step.task.name}' reads '{name}', which is gone by then")


def _unshared(plan: Plan, when: Mapping[str, object]) -> Plan:
    """Return the plan with a texture of its own for each resource that a pass which may not run reads or writes: it may have to
    stand for others for longer than the largest frame needs it."""
    own = {name for step in plan.steps if step.task.name in when for name in (*step.task.reads, *step.writes)}
    slots: list[Slot] = []
    placed: dict[int | str, int] = {}

    def place(name: str, slot: int) -> int:
        key = name if name in own else slot
        if key not in placed:
            placed[key] = len(slots)
            slots.append(plan.slots[slot])
        return placed[key]

    where = {name: place(name, slot) for name, slot in plan.where.items()}
    steps = [
        replace(
            step,
            slots=tuple(where[name] for name in step.writes),
            depth_slot=None if step.depth_slot is None else placed[step.depth_slot],
        )
        for step in plan.steps
    ]
    return replace(plan, slots=tuple(slots), where=where, steps=tuple(steps))
