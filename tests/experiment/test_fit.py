"""Tests of ``experiment/fit.py``."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.experiment import fit


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
