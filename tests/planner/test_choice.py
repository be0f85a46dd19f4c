"""The planner's pure parts: which prediction is chosen, what costs and errors are predicted from, what invalidates the cache."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import ssao_gl as ao
from ssao_gl.planner.choice import Prediction, Target, choose

from ..command_line import refused

# choice

positive = st.floats(1e-3, 1e3)
some = st.lists(st.tuples(positive, positive), min_size=1, max_size=12).map(
    lambda pairs: [Prediction(f"p{i}", ms, error) for i, (ms, error) in enumerate(pairs)]
)


@given(some, positive, positive)
def test_more_time_is_never_worse(predictions: list[Prediction], one: float, other: float) -> None:
    low, high = sorted((one, other))
    try:
        few = choose(predictions, Target(budget_ms=low))
    except ao.SettingsError:
        assert all(p.ms > low for p in predictions)
        return
    many = choose(predictions, Target(budget_ms=high))
    assert few.ms <= low and many.ms <= high and many.error <= few.error
    assert few.error == min(p.error for p in predictions if p.ms <= low)


@given(some, positive, positive)
def test_more_error_is_never_dearer(predictions: list[Prediction], one: float, other: float) -> None:
    low, high = sorted((one, other))
    try:
        strict = choose(predictions, Target(max_error=low))
    except ao.SettingsError:
        assert all(p.error > low for p in predictions)
        return
    loose = choose(predictions, Target(max_error=high))
    assert strict.error <= low and loose.error <= high and loose.ms <= strict.ms
    assert strict.ms == min(p.ms for p in predictions if p.error <= low)


@given(some, positive, positive)
def test_both_targets_hold(predictions: list[Prediction], budget: float, bound: float) -> None:
    fit = [p for p in predictions if p.ms <= budget and p.error <= bound]
    try:
        chosen = choose(predictions, Target(budget_ms=budget, max_error=bound))
    except ao.SettingsError:
        assert not fit
        return
    assert chosen in fit and chosen.ms == min(p.ms for p in fit)


@pytest.mark.parametrize(
    ("target", "nearest"),
    [({"budget_ms": 5}, "quick: 10 ms, RMSE 0.100"), ({"max_error": 0.01}, "good: 40 ms, RMSE 0.020"),
     ({"budget_ms": 12, "max_error": 0.05}, "quick: 10 ms, RMSE 0.100")],
)  # fmt: skip
def test_out_of_reach_says_what_is_nearest(target: dict[str, float], nearest: str) -> None:
    predictions = [Prediction("good", 40, 0.02), Prediction("quick", 10, 0.1)]
    with pytest.raises(ao.SettingsError) as caught:
        choose(predictions, Target(**target))
    assert str(caught.value).endswith(f"is out of reach here; the nearest is {nearest}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("bad", [0, -1.0, float("nan"), float("inf"), True, "5"])
@pytest.mark.parametrize("name", ["budget_ms", "max_error"])
def test_targets_are_numbers_above_zero(name: str, bad: Any) -> None:
    with pytest.raises(ao.SettingsError, match=f"{name}=.*: must be a finite number above 0"):
        Target(**{name: bad})


def test_a_target_names_something() -> None:
    with pytest.raises(ao.SettingsError, match="budget_ms, max_error or both"):
        Target()


# candidates


# costs


# errors


# cache


# command line

GOAL = ("--budget-ms", "50")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--budget-ms", "0"), "budget_ms=0.0: must be a finite number above 0"),
        (("--max-error", "nan"), "max_error=nan: must be"),
        ((*GOAL, "--preset", "high"), "--preset high: --budget-ms and --max-error choose that"),
        ((*GOAL, "--samples", "4", "--method", "alchemy"), "--samples 4: --budget-ms"),
    ],
)
@pytest.mark.parametrize("command", ["render", "explain", "apply"])
def test_bad_targets_are_one_line(
    command: str, arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    needed = ("--depth", "no.npy", "--yfov-deg", "40") if command == "apply" else ()
    assert message in refused(capsys, command, *needed, *arguments)
