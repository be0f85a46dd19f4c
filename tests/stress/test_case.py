"""Tests of ``stress/case.py``."""

from __future__ import annotations

import pytest

from ssao_gl.stress.case import Case
from ssao_gl.stress.catalogue import cases


@pytest.mark.parametrize("case", cases().values(), ids=lambda case: case.name)
def test_a_case_says_what_it_promises(case: Case) -> None:
    assert len(case.promise) > 20 and case.unit and case.bound >= 0
    assert case.why or abs(case.bound - 1 / 255) < 1e-5, "a bound that is not one step of 8 bits has a reason"
