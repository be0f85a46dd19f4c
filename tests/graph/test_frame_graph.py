"""The frame graph: order, culling, sharing of textures, errors. No OpenGL."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.errors import GraphError
from ssao_gl.graph import names as resources
from ssao_gl.graph.declare import PREVIOUS, Pass, Texture
from ssao_gl.graph.draws import FloatTable, Fullscreen, ViewValue
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.plan import Plan
from ssao_gl.methods.bitmask import Bitmask
from ssao_gl.pipeline.build import plan_apply, plan_render
from ssao_gl.pipeline.settings import Settings

FRAME = (64, 48)
SETTINGS = Settings(method=Bitmask(radius=1.0))


def task(name: str, reads: str = "", writes: str = "", depth: str | None = None, **formats: Texture) -> Pass:
    targets = {w: formats.get(w, Texture("r8")) for w in writes.split()}
    draw = Fullscreen("any.frag", {f"u_{number}": read for number, read in enumerate(reads.split())})
    return Pass(name, "prepare", draw, targets, depth)


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
    one, two = (plan_render(SETTINGS, FRAME) for _ in range(2))
    assert one == two
    text = one.describe()
    assert "gbuffer" in text and "left out: layer behind" in text and "MiB" in text
    assert plan_render(dataclasses.replace(SETTINGS, blur=None), FRAME).culled["blur"] == "switched off"


def test_equal_plans_draw_the_same_and_others_do_not() -> None:
    """What is drawn is part of a plan's value: the layout alone is what plans of other numbers share."""
    one = plan_render(SETTINGS, FRAME)
    other = plan_render(Settings(method=Bitmask(radius=2.0)), FRAME)
    assert one != other and one.layout == other.layout
    mobile = plan_render(dataclasses.replace(SETTINGS, precision="mobile"), FRAME)
    assert mobile != one and mobile.layout == one.layout
    assert all(step.task.draw.defines.get("MOBILE") for step in mobile.steps if isinstance(step.task.draw, Fullscreen))
    assert plan_render(dataclasses.replace(SETTINGS, blur=None), FRAME).layout != one.layout


def history(name: str, *reads: str, **other: Texture) -> Pass:
    draw = Fullscreen("any.frag", {f"u_{number}": read for number, read in enumerate(reads)})
    return Pass(name, "prepare", draw, {name: Texture("r32f", lifetime="history"), **other})


def test_a_history_is_read_before_it_is_written_anew() -> None:
    passes = [task("now", "", "now"), history("mean", "now", f"mean{PREVIOUS}"), task("show", "mean", "show")]
    plan = compile(passes, FRAME, ["show"])
    assert names(plan) == ["now", "mean", "show"]
    assert plan.history == {"mean": (plan.where["mean"], plan.where[f"mean{PREVIOUS}"])}
    assert plan.layout.history == (plan.history["mean"],)


def test_what_the_next_frame_reads_is_written_and_its_slots_are_nobody_elses() -> None:
    """The writer of a history runs even where this frame alone would not need it."""
    passes = [task("a", f"b{PREVIOUS}", "a"), history("b", "c"), task("c", "", "c"), task("d", "a", "d"), task("e", "d", "e")]
    plan = compile(passes, FRAME, ["e"])
    assert {"b", "c"} <= set(names(plan))
    pair = plan.history["b"]
    assert len(set(pair)) == 2 and not set(pair) & {plan.where[name] for name in "acde"}


@pytest.mark.parametrize(
    ("passes", "inputs", "message"),
    [
        ([task("a", f"b{PREVIOUS}", "a"), task("b", "", "b")], [], "'b' has no history"),
        ([task("a", f"b{PREVIOUS}", "a")], ["b"], "'b' has no history"),
        ([task("a", f"nobody{PREVIOUS}", "a")], [], "needs 'nobody'"),
    ],
)
def test_only_a_history_can_be_remembered(passes: list[Pass], inputs: list[str], message: str) -> None:
    with pytest.raises(GraphError, match=message):
        compile(passes, FRAME, ["a"], inputs)


def test_a_3d_texture_counts_all_its_layers() -> None:
    plan = compile([task("a", "", "a", a=Texture("rgba16f", depth=32))], FRAME, ["a"])
    assert plan.bytes == 8 * 64 * 48 * 32


def test_tables_are_values() -> None:
    values = [[0.25, 1.0], [2.0, -3.0]]
    assert FloatTable.of(values) == FloatTable.of(values) and hash(FloatTable.of(values)) == hash(FloatTable.of(values))
    assert FloatTable.of(values).array().tolist() == values and FloatTable.of(values) != FloatTable.of([[0.25, 1.0]])
    with pytest.raises(GraphError, match="Did you mean 'pixel'"):
        ViewValue("pixels")


def test_depth_only_gbuffer_when_only_depth_is_wanted() -> None:
    assert plan_render(SETTINGS, FRAME, ("depth",)).steps[0].writes == (resources.DEPTH,)
    assert names(plan_render(SETTINGS, FRAME, ("depth",))) == ["gbuffer"]


def test_apply_rebuilds_normals_only_when_none_are_given() -> None:
    assert "normals" in names(plan_apply(SETTINGS, FRAME))
    assert "encode normals" in names(plan_apply(SETTINGS, FRAME, normals=True))


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
