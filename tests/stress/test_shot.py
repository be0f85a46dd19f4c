"""Tests of ``stress/shot.py``."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.stress.analytic_depth import cast, room
from ssao_gl.stress.reduce import smaller
from ssao_gl.stress.shapes import lens
from ssao_gl.stress.shot import Shot, apart, share


def test_differences() -> None:
    a, b = np.array([0.0, 0.5, 1.0, 1.0]), np.array([0.0, 0.5 + 1 / 255, 1.0, 0.9])
    assert share(a, b) == 0.25 and apart(a, b) == pytest.approx((1 / 255 + 0.1) / 4)


def test_a_failure_is_made_as_small_as_it_gets() -> None:
    depth = cast(lens(), (32, 24), *room()).astype(np.float32)
    depth[13, 17] = np.inf
    normals = np.ones((24, 32, 3), np.float32)
    shot = Shot(lens(), depth=depth, normals=normals, blur="joint", changes={"bias": 0.1})
    tried = []

    def fails(candidate: Shot) -> bool:
        tried.append(candidate)
        return bool(np.isinf(np.asarray(candidate.depth)).any())

    found = smaller(shot, fails)
    assert found.depth is not None and found.depth.shape == (1, 1) and np.isinf(found.depth).all()
    assert (found.normals, found.blur, found.changes) == (None, "none", {}) and len(tried) < 60


def test_a_failure_keeps_what_it_needs() -> None:
    """Two texels that fail only together, and only filtered."""
    depth = np.full((8, 8), 5, np.float32)

    def fails(candidate: Shot) -> bool:
        z = np.asarray(candidate.depth)
        return z.shape == (8, 8) and z[1, 2] > 0 and z[6, 5] > 0 and candidate.blur == "joint"

    found = smaller(Shot(lens(), depth=depth, blur="joint"), fails)
    assert found.depth is not None and np.count_nonzero(found.depth) == 2 and found.blur == "joint"
