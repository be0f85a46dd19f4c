"""The arithmetic of the report: fronts, fits, intervals, tables. No OpenGL, no rays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssao_gl.errors import SettingsError
from ssao_gl.experiment import fit, pareto, pictures, points, statistics, timing, variants
from ssao_gl.experiment.sweep import split_size
from ssao_gl.gl.timer import PassTime
from ssao_gl.io.json_values import to_json
from ssao_gl.report import compare, labels, markdown, tables


def test_front_is_what_nothing_beats() -> None:
    assert pareto.front([(1, 3), (2, 2), (3, 2), (2, 2.5), (4, 1)]) == [True, True, False, False, True]
    assert pareto.front([(1, 1), (1, 1)]) == [True, True]  # equals do not beat each other
    assert pareto.front([]) == []


def test_hypervolume_of_known_boxes() -> None:
    times = (1.0, math.e**2)
    assert pareto.hypervolume([(1.0, 0.0)], times, 1.0) == pytest.approx(1)
    assert pareto.hypervolume([(math.e, 0.5)], times, 1.0) == pytest.approx(0.25)
    assert pareto.hypervolume([(1.0, 0.5), (math.e, 0.0)], times, 1.0) == pytest.approx(0.75)
    assert pareto.hypervolume([(0.1, 0.5)], times, 1.0) == pytest.approx(0.5)  # faster than the box counts as its edge
    assert pareto.hypervolume([(math.e, 2.0), (100.0, 0.1)], times, 1.0) == 0
    more = pareto.hypervolume([(1.0, 0.5), (math.e, 0.4), (2.0, 0.6)], times, 1.0)
    assert more == pytest.approx(pareto.hypervolume([(1.0, 0.5), (math.e, 0.4)], times, 1.0))  # dominated points add nothing


def test_best_within_a_budget() -> None:
    some = [(10.0, 0.1), (20.0, 0.05)]
    assert pareto.at_time(some, 15) == 0.1 and pareto.at_time(some, 5) is None
    assert pareto.at_error(some, 0.06) == 20 and pareto.at_error(some, 0.01) is None


def levels(visibility: np.ndarray, truth: np.ndarray) -> fit.Levels:
    return fit.Levels.of(visibility, truth, np.ones(truth.shape, bool))


def test_levels_hold_the_exact_error() -> None:
    random = np.random.default_rng(1)
    visibility, truth = random.integers(0, 256, (20, 30)) / 255, random.random((20, 30))
    scalars = fit.Scalars(1, 1.7, 0.6)
    sums = fit.Levels.loaded(levels(visibility, truth).saved())
    mapped = scalars(np.arange(256) / 255)
    assert sums.rmse(mapped) == pytest.approx(np.sqrt(np.mean((scalars(visibility) - truth) ** 2)), rel=1e-6)


@pytest.mark.parametrize(("strength", "power"), [(1.0, 1.0), (0.5, 2.0), (1.8, 0.7), (2.5, 1.0)])
def test_fit_finds_the_scalars_that_made_the_truth(strength: float, power: float) -> None:
    random = np.random.default_rng(2)
    views = [random.integers(64, 256, (40, 40)) / 255 for _ in range(3)]
    made = fit.Scalars(1.0, strength, power)
    right = [levels(v, made(v)) for v in views]
    wrong = [levels(v, random.random(v.shape)) for v in views]
    found, error = fit.fit({1.0: wrong, 1.41: right})
    assert found.radius == 1.41 and error < 2e-3
    at = np.linspace(0.25, 1, 50)
    np.testing.assert_allclose(found(at), made(at), atol=4e-3)


def test_bootstrap_sees_a_change_and_no_change() -> None:
    random = np.random.default_rng(3)
    before = random.uniform(0.05, 0.1, 18)
    low, high = compare.interval(before, before * random.uniform(1.03, 1.07, 18))
    assert 0.03 < low < 0.05 < high < 0.07
    low, high = compare.interval(before, before * random.uniform(0.9, 1.1, 18))
    assert low < 0 < high
    assert compare.interval(before, before) == (0, 0)
    assert compare.interval(before, before * 1.1) == compare.interval(before, before * 1.1)  # the seed is fixed


def report(**scale: float) -> dict[str, object]:
    times = {"total": {"wall": [1.0, 2.0, 3.0]}}
    rows = [
        {"variant": name, "view": f"v{i}", "errors": {"rmse": 0.1 * factor * (1 + 0.01 * i)}, "times": times, "baseline": {"wall": [1, 1, 1]}}
        for name, factor in scale.items()
        for i in range(4)
    ]  # fmt: skip
    return {"rows": {"estimate": [*rows, {"variant": "a", "view": "w", "refused": "no"}]}}


def test_comparison_names_regressions_only_beyond_the_limit() -> None:
    found = compare.changes(report(a=1, b=1, c=1, gone=1), report(a=1.05, b=0.9, c=1.01))
    verdicts = {change.label: change.verdict for change in found if change.what == compare.ERROR}
    assert verdicts == {"a": "worse", "b": "better", "c": "worse"}
    assert [change.label for change in compare.regressions(found, 0.02, None)] == ["a"]
    assert not compare.regressions(found, 0.06, None)


def test_exponent_of_a_power_law() -> None:
    sizes = [1e4, 1e5, 1e6]
    assert statistics.exponent(sizes, [3 * s**0.9 for s in sizes]) == pytest.approx(0.9)
    assert statistics.exponent([5, 5], [1, 2]) is None


def test_plain_has_no_infinities() -> None:
    assert to_json({"a": (np.float32(1), math.inf, math.nan), 2: np.arange(2)}) == {"a": [1.0, None, None], "2": [0, 1]}


def test_rounds_are_interleaved_and_the_first_is_dropped() -> None:
    order: list[str] = []

    def draw(name: str) -> list[PassTime]:
        order.append(name)
        return [
            PassTime("gbuffer", 50, "wall", 1, "gbuffer"),
            PassTime("alchemy", len(order), "wall", 2, "occlusion"),
            PassTime("blur x", 1, "wall", 3, "denoise"),
        ]

    runs = timing.interleaved({"a": lambda: draw("a"), "b": lambda: draw("b")}, 2)
    assert order == ["a", "b", "b", "a", "a", "b"]
    found = timing.summary(runs["a"])
    assert found["method"]["wall"][1] == 4.5 and found["total"]["wall"][1] == 5.5 and found["total"]["cpu"][1] == 5
    assert found["gbuffer"]["wall"][1] == 50 and list(found["passes"]) == ["gbuffer", "alchemy", "blur x"]


def test_variants_are_presets_or_ranges() -> None:
    names = [variant.label for variant in variants.variants(["alchemy"])]
    assert {"alchemy draft", "alchemy high"} <= set(names)
    assert [v.label for v in variants.variants(["lecture"], ["8"])] == ["lecture 8"]
    swept = variants.variants(["alchemy", "lecture"], ranges=["alchemy.samples=3,5", "alchemy.bias=0.002"])
    assert [v.label for v in swept][:2] == ["alchemy samples=3 bias=0.002", "alchemy samples=5 bias=0.002"]
    assert swept[1].settings.method.samples == 5  # type: ignore[attr-defined]
    assert "reference" not in {one.family for one in variants.variants()}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((["alchmy"],), "Did you mean 'alchemy'"),
        ((["alchemy"], ["drift"]), "Did you mean 'draft'"),
        ((["alchemy"], [], ["samples=3"]), "must be method.setting"),
        ((["alchemy"], [], ["lecture.samples=3"]), "no method 'lecture' in this report"),
        ((["alchemy"], [], ["alchemy.sample=3"]), "Did you mean 'samples'"),
    ],
)
def test_unknown_variants_say_what_there_is(arguments: tuple[list[str], ...], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        variants.variants(*arguments)


def row(variant: str, view: str, rmse: float, ms: float) -> dict[str, object]:
    clocks = {"wall": [ms, ms, ms], "cpu": [ms, ms, ms]}
    times = {"passes": {variant: clocks}, **dict.fromkeys((*timing.GROUPS, "total"), clocks)}
    return {"variant": variant, "view": view, "family": variant, "preset": "default", "realtime": True, "prepared": {"ms": 0.0, "bytes": 0}, "errors": {"rmse": rmse, "bias": 0.0},
            "times": times, "baseline": {"wall": [5, 5, 5], "cpu": [5, 5, 5]}}  # fmt: skip


def test_points_are_means_and_a_variant_that_sits_out_is_no_rival() -> None:
    rows = [
        row("a", "v", 0.1, 10),
        row("a", "w", 0.2, 20),
        row("b", "v", 0.3, 30),
        row("b", "w", 0.3, 30),
        row("c", "v", 0.01, 1),
    ]
    a, b, c = points.points(rows, {"v", "w"}, track="shipped")
    assert a["errors"]["rmse"] == pytest.approx(0.15) and a["wall"]["total"] == 15 and a["ratio"] == pytest.approx(3)
    assert (a["front"], b["front"], c["front"]) == (True, False, False) and c["views"] == 1


def test_constants_follow_from_moments() -> None:
    truth = np.array([0.2, 0.6, 1.0])
    view = {"view": "v", "mean": truth.mean(), "square": (truth**2).mean()}
    one, level = points.constants([view], set())
    assert one["errors"]["rmse"] == pytest.approx(np.sqrt(((1 - truth) ** 2).mean()))
    assert level["errors"]["rmse"] == pytest.approx(truth.std()) and level["errors"]["bias"] == pytest.approx(0)


def test_markdown_grid_aligns_numbers_and_escapes() -> None:
    table = tables.Table("T", "", (tables.Column("name"), tables.Column("x", ".2f")), [["a|b", 1.234], ["c", None]])
    assert markdown.grid(table).splitlines() == ["| name | x |", "|---|---:|", "| a\\|b | 1.23 |", "| c | – |"]


def test_names_do_not_cover_each_other() -> None:
    at = np.array([[100.0, 100], [104, 101], [108, 99], [110, 104]])
    sizes = np.full((4, 2), (60.0, 12.0))
    corners = labels.place_labels(at, sizes, (0, 0, 300, 300), [np.array([[0.0, 100], [300, 100]])])
    boxes = np.concatenate([corners, corners + sizes], 1)
    assert (labels.overlap(boxes, boxes) - np.diag([720.0] * 4)).max() == 0
    assert corners.min() >= 0 and (corners + sizes).max() <= 300


def test_error_colours_are_symmetric_about_white() -> None:
    dark, none, bright, nowhere = pictures.palette()[pictures.indices([-1.0, 0.0, 1.0, np.nan])]
    assert tuple(none) == (247, 247, 247) and dark[2] > dark[0] and bright[0] > bright[2] and tuple(nowhere) == pictures.NOWHERE
    assert pictures.reduced(np.ones((101, 961))).shape == (33, 320)


def test_split_size_keeps_the_shape() -> None:
    assert split_size((1280, 720)) == (320, 180) and split_size((64, 36)) == (64, 36)
