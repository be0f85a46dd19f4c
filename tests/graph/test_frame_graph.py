"""The frame graph: order, culling, sharing of textures, errors. No OpenGL."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.errors import GraphError
from ssao_gl.graph.declare import Pass, Texture
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.plan import Plan
from ssao_gl.pipeline.build import plan_apply, plan_render
from ssao_gl.pipeline.settings import Settings

FRAME = (64, 48)


def task(name: str, reads: str = "", writes: str = "", depth: str | None = None, **formats: Texture) -> Pass:
    targets = {w: formats.get(w, Texture("r8")) for w in writes.split()}
    return Pass(name, tuple(reads.split()), targets, lambda stage: None, depth)


def names(plan: Plan) -> list[str]:
    return [step.task.name for step in plan.steps]


def test_runs_in_the_order_of_need_and_culls_the_rest() -> None:
    plan = compile([task("c", "b", "c"), task("a", "", "a"), task("b", "a", "b"), task("d", "a", "d")], FRAME, ["c"])
    assert names(plan) == ["a", "b", "c"]
    assert plan.culled == {"d": "nothing wants what it writes"}


def test_targets_that_nobody_reads_are_not_written() -> None:
    plan = compile([task("g", "", "z normal color"), task("v", "z", "v")], FRAME, ["v"])
    assert plan.steps[0].writes == ("z",)
    assert set(plan.culled) == {"normal", "color"}


def test_slots_are_shared_when_lifetimes_allow_and_never_within_a_pass() -> None:
    plan = compile([task("a", "", "a"), task("b", "a", "b"), task("c", "b", "c"), task("d", "c", "d")], FRAME, ["d"])
    assert [plan.where[n] for n in "abcd"] == [0, 1, 0, 1]
    assert plan.bytes == 2 * 64 * 48 < plan.unaliased_bytes == 4 * 64 * 48


def test_an_output_keeps_its_slot_to_the_end() -> None:
    plan = compile([task("a", "", "a"), task("b", "a", "b"), task("c", "b", "c")], FRAME, ["a", "c"])
    assert plan.where["a"] not in (plan.where["b"], plan.where["c"])


def test_a_depth_buffer_lives_for_its_pass_alone() -> None:
    plan = compile([task("a", "", "a", "depth a"), task("b", "a", "b", "depth b")], FRAME, ["b"])
    assert plan.steps[0].depth_slot == plan.steps[1].depth_slot is not None


def test_sizes_round_up_and_never_reach_zero() -> None:
    assert Texture("r8", 0.5).size((1279, 719)) == (640, 360)
    assert Texture("r8", 0.25).size((1, 1)) == (1, 1)


def test_inputs_are_the_callers() -> None:
    plan = compile([task("b", "depth", "b")], FRAME, ["b"], ["depth"])
    assert "depth" not in plan.where


@pytest.mark.parametrize(
    ("passes", "outputs", "message"),
    [
        ([task("b", "visibilty", "b"), task("a", "", "visibility")], ["b"], "Did you mean 'visibility'"),
        ([task("a", "", "x"), task("b", "", "x")], ["x"], "also written by pass 'a'"),
        ([task("a", "b", "a"), task("b", "a", "b")], ["a"], "wait for each other: a -> b -> a"),
        ([task("a", "", "a", a=Texture("r9"))], ["a"], "'r9'"),
        ([task("a", "", "x y", x=Texture("r8"), y=Texture("r8", 0.5))], ["x", "y"], "one size"),
        ([task("a", "", "a"), task("a", "", "b")], ["a"], "two passes are called 'a'"),
        ([task("a", "", "a")], ["b"], "the caller needs 'b'"),
        ([task("a", "", "depth")], ["depth"], "also written by the caller"),
    ],
)
def test_errors_name_the_pass_and_the_near_miss(passes: list[Pass], outputs: list[str], message: str) -> None:
    inputs = ["depth"] if "caller" in message and "also" in message else []
    with pytest.raises(GraphError, match=message.replace("(", "\\(")):
        compile(passes, FRAME, outputs, inputs)


def test_a_plan_is_a_value_and_prints_itself() -> None:
    one, two = (plan_render(Settings(), FRAME) for _ in range(2))
    assert one == two
    text = one.describe()
    assert "gbuffer" in text and "left out: layer behind" in text and "MiB" in text
    assert plan_render(Settings(blur=None), FRAME).culled["blur"] == "switched off"


def test_depth_only_gbuffer_when_only_depth_is_wanted() -> None:
    assert plan_render(Settings(), FRAME, ("depth",)).steps[0].writes == ("z",)
    assert names(plan_render(Settings(), FRAME, ("depth",))) == ["gbuffer"]


def test_apply_rebuilds_normals_only_when_none_are_given() -> None:
    assert "normals" in names(plan_apply(Settings(), FRAME))
    assert "encode normals" in names(plan_apply(Settings(), FRAME, normals=True))


@st.composite
def graphs(draw: st.DrawFn) -> tuple[list[Pass], list[str]]:
    count = draw(st.integers(1, 9))
    passes = []
    for i in range(count):
        reads = draw(st.lists(st.integers(0, i - 1), max_size=3)) if i else []
        passes.append(task(f"p{i}", " ".join(f"r{j}" for j in reads), f"r{i}", draw(st.sampled_from([None, f"depth{i}"]))))
    outputs = draw(st.lists(st.integers(0, count - 1), min_size=1, max_size=3, unique=True))
    return draw(st.permutations(passes)), [f"r{i}" for i in outputs]


@given(graphs())
def test_invariants_of_any_graph(graph: tuple[list[Pass], list[str]]) -> None:
    passes, outputs = graph
    plan = compile(passes, FRAME, outputs)
    position = {name: i for i, step in enumerate(plan.steps) for name in step.writes}
    last = {name: max((i for i, s in enumerate(plan.steps) if name in s.task.reads), default=-1) for name in position}
    for index, step in enumerate(plan.steps):
        assert all(position[read] < index for read in step.task.reads)
        touched = [plan.where[n] for n in (*dict.fromkeys(step.task.reads), *step.writes)]
        assert len(set(touched)) == len(touched)  # no pass reads what it draws into
        assert step.depth_slot not in touched
    for a in position:
        for b in position:
            if a < b and plan.where[a] == plan.where[b]:
                early, late = sorted((a, b), key=position.__getitem__)
                assert last[early] < position[late] and early not in outputs
