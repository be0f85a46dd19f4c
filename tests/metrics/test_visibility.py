"""Metrics against values worked out by hand."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ssao_gl import Camera
from ssao_gl.errors import FormatError, SettingsError
from ssao_gl.metrics.visibility import (
    bias,
    border_band,
    dilated,
    edge_band,
    flip,
    maximum,
    measure,
    noise,
    percentile,
    psnr,
    rmse,
    ssim,
)

SHAPE = (60, 80)
DEPTH = np.full(SHAPE, 2.0)
KEYS = ["rmse", "bias", "p95", "p99", "max", "psnr", "ssim", "flip", "noise", "rmse_edges", "rmse_interior", "rmse_border"]


def test_plain_numbers() -> None:
    truth = np.full((1, 100), 0.5)
    found = truth + np.arange(100) / 1000 * np.where(np.arange(100) % 2, 1, -1)
    where = np.ones((1, 100), bool)
    error = np.arange(100) / 1000
    assert rmse(found, truth, where) == pytest.approx(np.sqrt((error**2).mean()))
    assert bias(found, truth, where) == pytest.approx(0.0005)
    assert percentile(found, truth, where, 95) == pytest.approx(0.09405)
    assert maximum(found, truth, where) == pytest.approx(0.099)
    assert psnr(found, truth, where) == pytest.approx(-20 * np.log10(np.sqrt((error**2).mean())))


def test_equal_images() -> None:
    image = np.random.default_rng(0).random(SHAPE)
    got = measure(image, image, DEPTH)
    assert list(got) == KEYS
    assert got["psnr"] == np.inf and got["ssim"] == pytest.approx(1) and np.isnan(got["rmse_edges"])
    assert all(got[k] == 0 for k in KEYS if k not in ("psnr", "ssim", "rmse_edges"))


def test_background_counts_nowhere() -> None:
    random = np.random.default_rng(1)
    depth = DEPTH.copy()
    depth[:, 40:] = 0
    truth, found = random.random((2, *SHAPE))
    other = found.copy()
    other[:, 40:] = np.nan
    infinite = np.where(depth > 0, depth, np.inf)
    one, two = measure(found, truth, depth), measure(other, truth, infinite)
    assert one == two
    assert one["rmse"] == pytest.approx(np.sqrt(((found - truth)[:, :40] ** 2).mean()))
    assert one["rmse_edges"] == pytest.approx(np.sqrt(((found - truth)[:, 35:40] ** 2).mean()))


def test_nothing_to_measure_is_nan() -> None:
    assert all(np.isnan(v) for v in measure(DEPTH, DEPTH, 0 * DEPTH).values())


def test_noise_is_what_changes_from_pixel_to_pixel() -> None:
    random = np.random.default_rng(2)
    truth = np.full((200, 200), 0.6)
    depth = np.full((200, 200), 3.0)
    assert noise(truth - 0.2, truth, depth) == pytest.approx(0, abs=1e-7)
    assert noise(truth + random.normal(0, 0.05, truth.shape), truth, depth) == pytest.approx(0.05, rel=0.02)
    tiled = np.tile(random.normal(0, 0.05, (4, 4)), (50, 50))
    assert noise(truth + tiled, truth, depth) == pytest.approx(tiled.std(), rel=0.1)
    step = np.where(np.arange(200) < 100, 3.0, 4.0) * np.ones((200, 1))
    at_edge = truth + np.where(np.abs(np.arange(200) - 99.5) < 4, 0.3, 0) * random.normal(size=truth.shape)
    assert noise(at_edge, truth, step) == 0  # that is the edge band's


def test_edges_are_jumps_and_silhouettes_but_not_steep_floors() -> None:
    step = np.where(np.arange(80) < 40, 2.0, 2.1) * np.ones((60, 1))
    band = edge_band(step)
    assert band[:, 35:45].all() and not band[:, :35].any() and not band[:, 45:].any()
    assert not edge_band(np.where(np.arange(80) < 40, 2.0, 2.01) * np.ones((60, 1))).any()
    hole = DEPTH.copy()
    hole[30, 40] = 0
    assert edge_band(hole)[26:35, 36:45].all() and edge_band(hole).sum() < 130
    # A floor seen at a small angle: its depth changes by up to half from row to row.
    view = Camera.perspective(1.0, 0.1, 100.0).view((80, 60))
    c = view.points(np.ones(SHAPE))
    floor = -1 / np.minimum(c[..., 1], -1e-9)
    rows = slice(33, 60)
    assert np.diff(floor[rows, 0]).min() < -3
    assert not edge_band(floor[rows]).any()


def test_bands() -> None:
    one = np.zeros((20, 20), bool)
    one[10, 3] = True
    assert np.argwhere(dilated(one, 4)).min(0).tolist() == [6, 0] and dilated(one, 4).sum() == 9 * 8
    band = border_band((100, 100))
    assert band.sum() == 100**2 - 36**2 and not band[32, 32] and band[31, 50] and band[68, 50]
    assert border_band((40, 300)).all()


def test_ssim_and_flip_look_at_the_foreground() -> None:
    random = np.random.default_rng(3)
    truth = np.full(SHAPE, 0.7)
    found = truth.copy()
    found[:, :40] += random.normal(0, 0.1, (60, 40))
    left = np.zeros(SHAPE, bool)
    left[:, :36] = True
    right = np.zeros(SHAPE, bool)
    right[:, 48:] = True
    assert ssim(found, truth, right) == pytest.approx(1) and ssim(found, truth, left) < 0.6
    assert flip(found, truth, left) > 4 * flip(found, truth, right)
    dark = np.full((*SHAPE, 3), 5, np.uint8)
    assert flip(found, truth, left, dark) < flip(found, truth, left)  # on black nothing is seen


def test_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(FormatError, match="agree"):
        measure(DEPTH, DEPTH[1:], DEPTH)
    with pytest.raises(FormatError, match="not finite"):
        measure(np.full(SHAPE, np.nan), DEPTH, DEPTH)
    where = np.ones(SHAPE, bool)
    for module, metric in (("skimage.metrics", ssim), ("flip_evaluator", flip)):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(SettingsError, match=r"pip install 'ssao_gl\[metrics\]'"):
            metric(DEPTH / 4, DEPTH / 4, where)
