"""Spherical harmonics of light from all around."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.errors import FormatError
from ssao_gl.scene.harmonics import constant, gradient, polynomials, projected


def panorama(of: object, h: int = 32) -> np.ndarray:
    theta, phi = np.pi * (np.arange(h) + 0.5) / h, 2 * np.pi * (np.arange(2 * h) + 0.5) / (2 * h) - np.pi
    sine = np.sin(theta)[:, None]
    d = np.stack([sine * np.sin(phi), np.cos(theta)[:, None] + 0 * phi, -sine * np.cos(phi)], -1)
    return of(d)  # type: ignore[operator]


def test_what_harmonics_hold_comes_back() -> None:
    wanted = np.random.default_rng(1).normal(size=(9, 3)) * 0.1
    wanted[0] = 2.0
    made = projected(panorama(lambda d: polynomials(d) @ wanted))
    np.testing.assert_allclose(np.reshape(made, (9, 3)), wanted, atol=1e-12)
    np.testing.assert_allclose(projected(np.ones((8, 16, 3))), constant((1, 1, 1)), atol=1e-12)


def test_a_gradient_is_its_ends() -> None:
    light = np.reshape(gradient((1, 2, 3), (0, 1, 5)), (9, 3))
    np.testing.assert_allclose(polynomials([[0, 1, 0], [0, -1, 0]]) @ light, [[1, 2, 3], [0, 1, 5]])


def test_light_that_cannot_be() -> None:
    with pytest.raises(FormatError):
        projected(np.full((4, 8, 3), np.nan))
