"""Tests of ``experiment/pareto.py``."""

from __future__ import annotations

import math

import pytest

from ssao_gl.experiment import pareto


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
