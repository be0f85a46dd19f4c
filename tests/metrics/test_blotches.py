"""The band of blotches against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.metrics.blotches import blotches_in, noise_gain
from ssao_gl.metrics.visibility import blotches

SIDE = 256
FLAT = np.ones((SIDE, SIDE), bool)


def sine(wavelength: float, amplitude: float = 0.1) -> np.ndarray:
    return amplitude * np.sin(2 * np.pi * np.arange(SIDE) / wavelength) * np.ones((SIDE, 1))


def passed(wavelength: float) -> float:
    return 0.5 ** ((8 / wavelength) ** 2) - 0.5 ** ((64 / wavelength) ** 2)


@pytest.mark.parametrize("wavelength", [4, 8, 16, 22.6, 32, 64])
@pytest.mark.parametrize("turned", [False, True])
def test_a_sine_is_found_by_its_amplitude(wavelength: float, turned: bool) -> None:
    """Away from the image's border, where the band has nothing beyond it to go by."""
    error = sine(wavelength)
    band = blotches_in(error.T if turned else error, FLAT).reshape(SIDE, SIDE)
    band = (band.T if turned else band)[:, 48:-48]
    expected = passed(wavelength) * error[:, 48:-48]
    assert np.abs(band - expected).max() < 0.001
    if wavelength in (16, 22.6, 32):
        assert np.abs(band).max() > 0.08


@pytest.mark.parametrize("wavelength", [2.5, 3, 600])
def test_what_is_faster_or_slower_is_none(wavelength: float) -> None:
    error = sine(wavelength)
    assert np.abs(blotches_in(error, FLAT).reshape(SIDE, SIDE)[:, 48:-48]).max() < 0.02 * 0.1


def test_a_bias_is_none_whatever_the_zone() -> None:
    random = np.random.default_rng(0)
    flat = random.random((SIDE, SIDE)) < 0.3
    assert np.abs(blotches_in(np.full((SIDE, SIDE), 0.2), flat)).max() < 1e-12


def test_what_lies_outside_the_flat_zone_stays_there() -> None:
    flat = FLAT.copy()
    flat[:, 100:120] = False
    error = np.where(flat, 0.0, 0.5)
    assert blotches(error, 0 * error, FLAT) > 0.05 and blotches(error, 0 * error, flat) == 0
    wave = sine(16)
    assert blotches(wave, 0 * wave, flat) == pytest.approx(0.1 * passed(16) / np.sqrt(2), rel=0.05)
    assert np.isnan(blotches(wave, 0 * wave, FLAT & False))


def test_the_share_of_noise_in_the_band() -> None:
    noise = np.random.default_rng(1).normal(size=(4 * SIDE, 4 * SIDE))
    band = blotches_in(noise, np.ones_like(noise, bool)).reshape(noise.shape)[48:-48, 48:-48]
    assert band.var() == pytest.approx(noise_gain(), rel=0.02)
