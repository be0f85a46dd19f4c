"""Tests of ``experiment/statistics.py``."""

from __future__ import annotations

import pytest

from ssao_gl.experiment import statistics


def test_exponent_of_a_power_law() -> None:
    sizes = [1e4, 1e5, 1e6]
    assert statistics.exponent(sizes, [3 * s**0.9 for s in sizes]) == pytest.approx(0.9)
    assert statistics.exponent([5, 5], [1, 2]) is None
