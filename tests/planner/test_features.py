"""Tests of ``planner/features.py``."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.planner import error_model
from ssao_gl.planner.candidates import CANDIDATES
from ssao_gl.planner.features import ViewFeatures, off_plane, view_features
from ssao_gl.scene.projection import ViewConstants


def test_nothing_is_wrong_where_nothing_is_seen() -> None:
    empty = view_features(
        *[np.ones((4, 6), np.float32)] * 3, np.zeros((4, 6), np.float32), np.zeros((4, 6, 3), np.float32), VIEW, 1.0
    )
    assert empty == ViewFeatures(0, 0, 0, 0)
    assert all(error_model.predicted(name, empty, 2) == 0 for name in CANDIDATES)


VIEW = ViewConstants((6, 4), ao.Camera.perspective(0.9, 0.1, 10).view((6, 4)).projection)


def test_a_plane_is_not_rough_and_a_step_is() -> None:
    normals = np.broadcast_to(np.array([0, 0, 1], np.float32), (4, 6, 3))
    depth = np.full((4, 6), 2, np.float32)
    assert off_plane(depth, normals, VIEW, 1.0).max() == 0
    depth[:, 3:] = 2.5
    found = off_plane(depth, normals, VIEW, 1.0)
    assert found[:, 2:4] == pytest.approx(0.5) and found[:, [0, 1, 4, 5]].max() < 1e-6
    depth[:, 3:] = 9
    assert off_plane(depth, normals, VIEW, 1.0).max() == 1, "no more than a radius"
    depth[:, 3:] = 0
    assert off_plane(depth, normals, VIEW, 1.0).max() == 0, "background is no neighbour"


def test_signs_are_what_pictures_differ_by() -> None:
    depth, normals = np.full((4, 6), 2, np.float32), np.broadcast_to(np.array([0, 0, 1], np.float32), (4, 6, 3))
    depth[:, 0] = 0
    fine = np.full((4, 6), 0.8, np.float32)
    coarse, deep = fine + 0.1, fine - 0.2
    coarse[:, 0] = deep[:, 0] = 0  # background counts nothing
    found = view_features(fine, coarse, deep, depth, normals, VIEW, 1.0)
    assert (found.sampling, found.hidden, found.rough) == pytest.approx((0.1, 0.2, 0), abs=1e-6)
    assert view_features(fine, coarse, None, depth, normals, VIEW, 1.0).hidden == 0
