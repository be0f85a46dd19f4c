"""Rays against form factors known on paper."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.truth import Tracing, gather, surface
from ssao_gl.truth.closed_forms import closed_forms, disk_factor

NAMES = ("plane", "wall", "ball", "raised_ball", "disk", "well", "trench", "bowl", "post")


def at(name: str, x: float, y: float, z: float) -> float:
    return float(closed_forms()[name].visibility(np.array([[x, y, z]]))[0])


def test_all_are_there() -> None:
    assert tuple(closed_forms()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_rays_agree(name: str) -> None:
    form = closed_forms()[name]
    seen = surface(form.scene, form.camera, (12, 9))
    exact = form.visibility(seen.points())
    known = np.isfinite(exact)
    assert known.sum() >= 24
    found = gather(seen, Tracing(radius=form.radius, spp=16384))
    error = (found.visibility[found.covered] - exact)[known]
    assert np.abs(error).max() < 0.003
    assert abs(error.mean()) < 0.0005


def test_values_at_the_documented_points() -> None:
    assert at("wall", 1e-9, 0, 0) == pytest.approx(0.5)
    assert at("wall", 0.5, 0, 3) == pytest.approx(1 - (np.arccos(0.5) - 0.5 * np.sqrt(0.75)) / np.pi)
    assert at("wall", 0, 0.5, 3) == at("wall", 0.5, 0, 3)
    assert at("wall", 1.5, 0, 0) == 1
    assert at("ball", 0, 0, 1) == pytest.approx(1 - 1 / 2**1.5)
    assert at("raised_ball", 0, 0, 0) == pytest.approx(1 - 1 / 4)
    assert at("disk", 0, 0, 0) == pytest.approx(1 - 1 / (1 + 1.2**2))
    assert at("well", 0, 0, 0) == pytest.approx(1 - 1.5**2 / (1 + 1.5**2))
    assert at("trench", 0, 0, 5) == pytest.approx(1 / np.hypot(1, 1.5))
    assert at("bowl", 0, -1, 0) == 0.5
    assert at("post", 0, 0, 0.5) == pytest.approx(1 - np.arcsin(0.5) / np.pi)


@pytest.mark.parametrize("name", sorted(set(NAMES) - {"plane", "wall", "bowl"}))
def test_nothing_is_claimed_off_the_floor(name: str) -> None:
    assert np.isnan(at(name, 0.3, 0.5, 0.3))


def test_disk_factor_off_the_axis_is_an_integral_over_the_disk() -> None:
    radius, height, way = 0.8, 0.6, 1.1
    n = 1000
    r = (np.arange(n) + 0.5) / n * radius
    a = (np.arange(n) + 0.5) / n * 2 * np.pi
    x, z = r[:, None] * np.cos(a) - way, r[:, None] * np.sin(a)
    # cos cos' / (pi d^2) dA with both cosines h / d
    integral = (height**2 / (np.pi * (x**2 + z**2 + height**2) ** 2) * r[:, None]).sum() * (radius / n) * (2 * np.pi / n)
    assert disk_factor([[way, 0, 0]], radius, height)[0] == pytest.approx(integral, rel=1e-5)


def test_pixels_err_independently() -> None:
    form = closed_forms()["bowl"]  # a half everywhere
    found = gather(surface(form.scene, form.camera, (64, 48)), Tracing(radius=form.radius, spp=32))
    error = found.visibility - 0.5
    both = found.covered[:, 1:] & found.covered[:, :-1]
    together = (error[:, 1:] * error[:, :-1])[both].mean() / (error[found.covered] ** 2).mean()
    assert abs(together) < 0.1
