"""Tests of ``experiment/points.py``."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.experiment import points


def test_constants_follow_from_moments() -> None:
    truth = np.array([0.2, 0.6, 1.0])
    view = {"view": "v", "mean": truth.mean(), "square": (truth**2).mean()}
    one, level = points.constants([view], set())
    assert one["errors"]["rmse"] == pytest.approx(np.sqrt(((1 - truth) ** 2).mean()))
    assert level["errors"]["rmse"] == pytest.approx(truth.std()) and level["errors"]["bias"] == pytest.approx(0)
