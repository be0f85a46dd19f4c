"""Properties of the frame graph for any passes, found by Hypothesis: a plan that is right when it is run, or GraphError."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.errors import GraphError
from ssao_gl.graph.declare import DepthTest, Pass, Texture
from ssao_gl.graph.draws import Fullscreen
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.plan import Plan, Slot

FORMATS = ["r8", "rgba8", "r32f"]
Graph = tuple[list[Pass], list[str], list[str]]


def drawing(reads: Sequence[str]) -> Fullscreen:
    """What else a pass draws does not matter here."""
    return Fullscreen("any.frag", {f"u_{number}": name for number, name in enumerate(reads)})


@st.composite
def graphs(draw: st.DrawFn) -> Graph:
    """Passes in any order, outputs, inputs. Mostly valid: what a pass needs is written by one before it."""
    inputs = [f"in{i}" for i in range(draw(st.integers(0, 2)))]
    known: dict[str, Texture] = {}
    depths: dict[str, float] = {}
    passes = []
    for number in range(draw(st.integers(1, 9))):
        scale = draw(st.sampled_from([1.0, 1.0, 0.5]))
        pool = [*inputs, *known]
        reads = tuple(draw(st.lists(st.sampled_from(pool), max_size=3)) if pool else ())
        names = [f"r{number}{letter}" for letter in "abc"[: draw(st.integers(1, 3))]]
        writes = {name: Texture(draw(st.sampled_from(FORMATS)), scale) for name in names}
        over, test, depth = {}, None, None
        kind = draw(st.sampled_from(["plain", "plain", "depth", "over", "test", "over and test"]))
        if kind == "depth":
            depth = f"d{number}"
        fitting = [name for name in known if known[name].scale == scale]
        if "over" in kind and fitting:
            under = draw(st.sampled_from(fitting))
            over = {names[0]: under}
            writes[names[0]] = known[under]
        fitting = [name for name in depths if depths[name] == scale]
        if "test" in kind and fitting:
            test = DepthTest(draw(st.sampled_from(fitting)), draw(st.booleans()), draw(st.booleans()))
        passes.append(Pass(f"p{number}", "prepare", drawing(reads), writes, depth, test, over))
        known |= writes
        depths |= {depth: scale} if depth else {}
    outputs = draw(st.lists(st.sampled_from([*known]), min_size=1, max_size=3, unique=True))
    return draw(st.permutations(passes)), outputs, inputs


def compiled(graph: Graph, frame: tuple[int, int] = (63, 48)) -> Plan | None:
    passes, outputs, inputs = graph
    try:
        return compile(passes, frame, outputs, inputs)
    except GraphError as error:
        assert str(error).isprintable()
        return None


@given(graphs())
def test_a_plan_is_right_when_it_is_run(graph: Graph) -> None:
    """Each slot holds, at every step, what the pass expects in it; the outputs are there at the end. So no two resources
    that are needed at a time share a slot."""
    plan = compiled(graph)
    if plan is None:
        return
    _, outputs, inputs = graph
    held: dict[int, str] = {}
    for step in plan.steps:
        task = step.task
        for name in task.needs:
            assert name in inputs or held[plan.where[name]] == name, f"{task.name} needs {name}"
        drawn = [plan.where[name] for name in step.writes]
        drawn += [plan.where[task.depth]] if task.depth else []
        read = [plan.where[name] for name in task.reads if name not in inputs]
        assert len(set(drawn)) == len(drawn) and not set(drawn) & set(read), "reads what it draws into"
        for name in step.writes:
            assert plan.slots[plan.where[name]] == Slot(task.writes[name].format, step.size)
            assert name not in task.over or plan.where[name] == plan.where[task.over[name]]
            held[plan.where[name]] = name
        if task.depth:
            assert (
                plan.slots[plan.where[task.depth]] == Slot("depth24", step.size) and step.depth_slot == plan.where[task.depth]
            )
            held[plan.where[task.depth]] = task.depth
        elif task.test:
            assert step.depth_slot == plan.where[task.test.name]
        assert step.slots == tuple(plan.where[name] for name in step.writes)
    for name in outputs:
        assert held[plan.where[name]] == name


@given(graphs())
def test_what_runs_is_what_is_needed(graph: Graph) -> None:
    """Passes from which an output follows, and of their targets those that somebody wants; all else is culled, with a reason."""
    plan = compiled(graph)
    if plan is None:
        return
    passes, outputs, inputs = graph
    writer = {name: task for task in passes for name in (*task.writes, *([task.depth] if task.depth else []))}
    needed, stack = set(), list(outputs)
    while stack:
        name = stack.pop()
        if name not in inputs and name not in needed:
            needed.add(name)
            stack += writer[name].needs
    run = {step.task.name for step in plan.steps}
    assert run == {writer[name].name for name in needed}
    assert len(run) == len(plan.steps)
    for step in plan.steps:
        assert set(step.writes) == needed & set(step.task.writes)
        assert all(name in plan.culled for name in set(step.task.writes) - set(step.writes))
    for task in passes:
        assert (task.name in plan.culled) == (task.name not in run)
    assert plan.bytes <= plan.unaliased_bytes and plan.describe().count("\n") >= len(run)


@given(graphs(), st.randoms())
def test_a_plan_is_the_same_every_time(graph: Graph, random: object) -> None:
    """It is a value of its passes, and does not depend on the order in which those are listed."""
    plan = compiled(graph)
    assert compiled(graph) == plan
    passes, outputs, inputs = graph
    random.shuffle(passes)  # type: ignore[attr-defined]
    other = compiled((passes, outputs, inputs))
    assert (other is None) == (plan is None)
    if plan and other:
        assert (other.steps, other.slots, other.where) == (plan.steps, plan.slots, plan.where)


@st.composite
def wrong(draw: st.DrawFn) -> Graph:
    """A graph with one thing changed that may contradict the rest."""
    passes, outputs, inputs = draw(graphs())
    number = draw(st.integers(0, len(passes) - 1))
    task = passes[number]
    names = [name for each in passes for name in each.writes] + ["nobody", "d0", *inputs]
    name = draw(st.sampled_from(names))
    changes = [
        {"draw": drawing((*task.reads, name))},
        {"writes": {name: Texture("r8")}},
        {"writes": {}},
        {"writes": {**task.writes, "x": Texture("r9")}},
        {"writes": {**task.writes, "x": Texture("r8", 0.25)}},
        {"over": {next(iter(task.writes)): name}},
        {"test": DepthTest(name)},
        {"depth": name},
        {"name": passes[0].name},
    ]
    passes[number] = dataclasses.replace(task, **draw(st.sampled_from(changes)))  # type: ignore[arg-type]
    return passes, draw(st.sampled_from([outputs, [name], [*outputs, name]])), inputs


@given(wrong())
def test_contradictions_are_named(graph: Graph) -> None:
    """GraphError, in one line, and never another; what compiles all the same is right."""
    compiled(graph)
