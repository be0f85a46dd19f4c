"""Tests of ``stress/fuzz.py``."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssao_gl.stress import fuzz
from ssao_gl.stress.specimen import specimens


@pytest.mark.parametrize("number", [0, 5, 17, 33, 70, 1234567])
def test_a_random_case_is_its_seed_and_number(number: int) -> None:
    every = [fuzz.random_shot(3, number, subject) for subject in specimens()]
    again = fuzz.random_shot(3, number, specimens()[0])
    for shot in (*every, again):
        np.testing.assert_array_equal(shot.depth, every[0].depth)
        np.testing.assert_array_equal(shot.camera.view((8, 6)).projection, every[0].camera.view((8, 6)).projection)
        assert (shot.kind, shot.blur, shot.radius) == (every[0].kind, every[0].blur, every[0].radius)
    other = fuzz.random_shot(4, number, specimens()[0])
    assert other.depth is None or other.depth.shape != every[0].depth.shape or not np.array_equal(other.depth, every[0].depth)  # type: ignore[union-attr]


def test_random_cases_are_of_all_kinds() -> None:
    subject = specimens()[0]
    shots = [fuzz.random_shot(0, number, subject) for number in range(0, 2000)]
    assert {shot.kind for shot in shots} == {"eye", "window"} and {shot.normals is None for shot in shots} == {True, False}
    assert {shot.blur for shot in shots} == {"none", "joint", "separable", "lecture"}
    assert {shot.depth.shape[::-1] for shot in shots if shot.depth is not None} == set(fuzz.SIZES)
    views = [shot.camera.view((16, 12)) for shot in shots]
    assert {view.pinhole for view in views} == {True, False} and {math.isinf(view.far) for view in views} == {True, False}
    assert {view.depth_constants["u_depth_far"] for view in views} == {0.0, 1.0}
    hostile = [shot.depth for shot in shots if shot.depth is not None and not np.isfinite(shot.depth).all()]
    assert 100 < len(hostile) < 1500


def test_blocks_take_turns_over_the_subjects_that_draw_depth_images() -> None:
    every = [subject for subject in specimens() if not subject.method.traits.needs_scene]
    planned = list(fuzz.planned(0, range(len(every) * fuzz.BLOCK), specimens()))
    assert [subject for _, subject in planned[:: fuzz.BLOCK]] == every
