"""Comparing pictures: numbers, suffixes, errors; and colour times light."""

from __future__ import annotations

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.metrics.images import compare, difference_picture


def test_numbers() -> None:
    a = np.zeros((10, 10), np.uint8)
    b = a.copy()
    b[0, 0] = 51
    found = compare(a, b, ("rmse", "psnr", "ssim"))
    assert found.max_abs == 51 and found.share_above_1 == 0.01
    assert found.metrics["rmse"] == pytest.approx(0.02)
    assert found.metrics["psnr"] == pytest.approx(-20 * np.log10(0.02))
    assert compare(a, a, ("ssim",)).metrics["ssim"] == pytest.approx(1)


def test_floats_and_16_bits_have_their_own_units() -> None:
    a = np.zeros((4, 4), np.float32)
    assert compare(a, a + 0.25).max_abs == 0.25
    assert compare(a, np.where(np.eye(4), np.nan, 0)).max_abs == np.inf
    wide = np.zeros((4, 4), np.uint16)
    assert compare(wide, wide + 257).max_abs == pytest.approx(1.0)


def test_flip_of_equal_pictures_is_zero() -> None:
    pytest.importorskip("flip_evaluator")
    a = np.random.default_rng(0).integers(0, 255, (32, 32, 3)).astype(np.uint8)
    assert compare(a, a, ("flip",)).metrics["flip"] == pytest.approx(0, abs=1e-6)


def test_what_cannot_be_compared_is_refused() -> None:
    a = np.zeros((4, 4), np.uint8)
    with pytest.raises(ao.FormatError, match="shape"):
        compare(a, a[:2])
    with pytest.raises(ao.FormatError, match="float32"):
        compare(a, a.astype(np.float32))
    with pytest.raises(ao.SettingsError, match="Did you mean 'ssim'"):
        compare(a, a, ("ssmi",))


def test_difference_picture() -> None:
    a, b = np.full((4, 6), 10, np.uint8), np.full((4, 6), 12, np.uint8)
    picture = difference_picture(a, b)
    assert picture.shape == (4, 18, 3) and (picture[:, 12:] == 32).all()


def test_multiply_is_linear_light() -> None:
    white = np.full((1, 3, 4), 255, np.uint8)
    out = ao.multiply(white, np.array([[0.0, 0.2140, 1.0]]))
    np.testing.assert_array_equal(out[0, :, 0], [0, 127, 255])  # 0.2140 is the linear light of sRGB 127
    assert (out[..., 3] == 255).all()


def test_composite_on_the_gpu_is_linear_light_too(any_renderer: ao.Renderer) -> None:
    """All colours times all visibilities, against the exact curve: the polynomials of the shader are within 1/255."""
    rng = np.random.default_rng(2)
    color = rng.integers(0, 256, (96, 128, 3)).astype(np.uint8)
    color[:16] //= 16  # the dark end, where the sRGB curve is a line
    depth = rng.uniform(2, 3, (96, 128)).astype(np.float32)
    picture = any_renderer.apply(
        depth,
        ao.Camera.perspective(1.0),
        color=color,
        settings=ao.Settings(method=ao.Alchemy(radius=2.0), blur=None, shading=ao.Shading(ambient=1.0)),
    )
    assert picture.visibility.std() > 0.1
    assert np.abs(picture.image.astype(int) - ao.multiply(color, picture.visibility)).max() <= 1
