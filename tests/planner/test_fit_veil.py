"""The fit of shares: least squares that find what was put in, and data that say how they were made."""

from __future__ import annotations

import json
from importlib import resources

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SettingsError
from ssao_gl.methods.veil_fits import veil_fit
from ssao_gl.planner.fit_veil import FITTED, SHARES, ShareSums, fit_shares


def sums(scene: str, shares: np.ndarray, noise: float = 0.0) -> ShareSums:
    """Of 4000 pixels that are hidden by just these shares of three pictures, and by a noise besides."""
    random = np.random.default_rng(len(scene))
    x = random.uniform(0, 1, (4000, 3))
    y = x @ shares + noise * random.standard_normal(4000)
    return ShareSums(scene, x.T @ x / len(y), x.T @ y / len(y), float(np.mean(y**2)), noise**2)


def test_shares_are_found_again() -> None:
    shares = np.array([0.6, 0.25, 0.1])
    some = [sums("one", shares), sums("other", shares)]
    np.testing.assert_allclose(fit_shares(some), shares, atol=1e-9)
    assert some[0].rmse(shares) < 1e-6
    assert some[0].rmse(shares + [0.1, 0, 0]) == pytest.approx(0.1 * np.sqrt(1 / 3), rel=0.05)


def test_noise_of_the_truth_is_taken_out() -> None:
    shares = np.array([0.6, 0.25, 0.1])
    assert sums("noisy", shares, 0.05).rmse(shares) < 0.01


def test_a_veil_that_shows_nowhere_gets_no_share() -> None:
    one = sums("one", np.array([1.0, 0, 0]))
    one.gram[2], one.gram[:, 2], one.with_truth[2] = 0, 0, 0
    np.testing.assert_allclose(fit_shares([one]), [1, 0, 0], atol=1e-9)


def test_data_say_how_they_were_made() -> None:
    data = json.loads(resources.files("ssao_gl.methods").joinpath("veil_fits.json").read_text("utf-8"))
    assert data["record"]["views"] >= 18 and data["record"]["spp"] >= 64
    for kind, name in FITTED.items():
        fit = data["fits"][kind]
        assert fit["preset"] == name and fit["left_out"] < fit["of_slabs_alone"]
        assert ao.Bitmask(**ao.Bitmask.presets[name]).fitted == veil_fit(kind)
        assert sum(fit[share] for share in SHARES) == pytest.approx(1, abs=0.03), "what all agree on is hidden in full"


def test_settings_overrule_fits_one_by_one() -> None:
    assert ao.Bitmask(veil=0.0).fitted.veil == 0 and ao.Bitmask(veil=0.0).fitted.opacity == veil_fit("one layer").opacity
    plain = ao.Bitmask(opacity=1.0, near_veil=0.0, veil=0.0, radius=1.0)
    assert "VEIL" not in plain.defines() and "u_shares" not in plain.constants()
    with pytest.raises(SettingsError, match=r"bitmask\.veil=2"):
        ao.Bitmask(veil=2.0)
    with pytest.raises(SettingsError, match="there are scale 4"):
        veil_fit("three layers")
