"""Sensor noise: flat surfaces are open again, edges and exact corners stay."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import ssao_gl as ao
from ssao_gl.scene.depth_noise import denoise_depth
from ssao_gl.stress.analytic_depth import cast, flat

SIZE, FOCAL, BASE = (320, 240), 290.0, 0.075
CAMERA = ao.Camera.pinhole(FOCAL, FOCAL, 160, 120, SIZE)
STEP = 1 / (8 * FOCAL * BASE)
"""Of inverse depth: an eighth of a pixel of disparity."""
METHOD = ao.Bitmask(radius=0.3)


def floor() -> NDArray[np.float64]:
    z = cast(CAMERA, SIZE, flat((0, -1.1, -0.5), (0, 0.906, 0.423)))
    return np.where(z < 8, z, 0)


def quantised(z: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(z > 0, 1 / (STEP * np.maximum(np.round(1 / np.where(z > 0, z, 1) / STEP), 1)), 0)


def mean(any_renderer: ao.Renderer, z: NDArray[np.float64], noise: float) -> float:
    seen = any_renderer.apply(ao.DepthImage(z, noise=noise), CAMERA, settings=ao.Settings(method=METHOD)).visibility
    return float(seen[z > 0].mean())


@pytest.mark.parametrize("noise", [0.0012, 0.00166, 0.004])
def test_a_quantised_floor_is_open(any_renderer: ao.Renderer, noise: float) -> None:
    z = quantised(floor())
    assert mean(any_renderer, z, 0) < 0.9 and mean(any_renderer, z, noise) >= 0.97


@pytest.mark.parametrize("noise", [0.001, 0.002, 0.004])
def test_a_noisy_wall_is_open(any_renderer: ao.Renderer, noise: float) -> None:
    z = cast(CAMERA, SIZE, flat((0, 0, -1.5), (0.2, 0, 1)))
    z += np.random.default_rng(1).normal(0, 0.002, z.shape)
    assert mean(any_renderer, z, 0) < 0.9 and mean(any_renderer, z, noise) >= 0.97


@pytest.mark.parametrize("noise", [0.0005, 0.001, 0.004])
def test_an_exact_corner_stays(any_renderer: ao.Renderer, noise: float) -> None:
    z = cast(CAMERA, SIZE, flat((0, -0.8, 0), (0, 1, 0)), flat((-1, 0, 0), (1, 0, 0)), flat((0, 0, -3), (0, 0, 1)))
    exact, found = (
        any_renderer.apply(ao.DepthImage(z.astype(np.float32), noise=n), CAMERA, settings=ao.Settings(method=METHOD)).visibility
        for n in (0, noise)
    )
    assert exact.min() < 0.5 and np.abs(found - exact).max() < 0.03


def test_a_noisy_corner_comes_back(any_renderer: ao.Renderer) -> None:
    """Mean of the dark half near it, within .03 of the exact one's."""
    z = cast(CAMERA, SIZE, flat((0, -0.8, 0), (0, 1, 0)), flat((0, 0, -3), (0, 0, 1)))
    settings = ao.Settings(method=METHOD)
    exact = any_renderer.apply(z, CAMERA, settings=settings).visibility
    found = any_renderer.apply(ao.DepthImage(quantised(z), noise=0.00166), CAMERA, settings=settings).visibility
    assert abs(float((found - exact)[exact < 0.9].mean())) < 0.03 and np.abs(found - exact).mean() < 0.01


def test_edges_and_background_stay() -> None:
    z = np.full(SIZE[::-1], 2.0)
    z[:, 160:] = 3.0
    z[:60] = 0
    noisy = np.where(z > 0, z + np.random.default_rng(1).normal(0, 1, z.shape) * 0.002 * z * z, 0)
    found = denoise_depth(noisy, CAMERA, 0.002)
    assert (found[:60] == 0).all()
    error = np.abs(found - z)[60:] / z[60:] ** 2
    assert error.max() < 0.004 and np.sqrt((error**2).mean()) < 0.0004


def test_a_parallel_projection_has_no_such_noise() -> None:
    with pytest.raises(ao.SettingsError, match="perspective cameras only"):
        ao.DepthImage(np.ones((8, 8)), noise=0.1).linear(ao.Camera.orthographic(2, 0.1, 10))
