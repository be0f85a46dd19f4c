"""Metrics against values worked out by hand."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ssao_gl.errors import FormatError, SettingsError
from ssao_gl.metrics.visibility import (
    bias,
    border_band,
    flip,
    maximum,
    measure,
    net,
    noise,
    percentile,
    psnr,
    rmse,
    ssim,
)
from ssao_gl.metrics.zones import ZONES, Zones
from ssao_gl.report.columns import ALL_KEYS

SHAPE = (60, 80)
GREY = np.full(SHAPE, 0.5)
KEYS = list(ALL_KEYS)


def zones(
    edge: slice = slice(0, 0), crease: slice = slice(0, 0), seen: slice = slice(None), shape: tuple[int, int] = SHAPE
) -> Zones:
    """Zones that are columns of an image; what is in neither is flat."""
    masks = [np.zeros(shape, bool) for _ in range(3)]
    for mask, columns in zip(masks, (seen, edge, crease), strict=True):
        mask[:, columns] = True
    return Zones(masks[0] & masks[1], masks[0] & masks[2], masks[0] & ~masks[1] & ~masks[2])


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
    got = measure(image, image, zones(), stderr=0 * image)
    assert sorted(got) == sorted(KEYS)
    assert got["psnr"] == np.inf and got["ssim"] == pytest.approx(1)
    nothing = {key for key in KEYS if np.isnan(got[key])}
    assert nothing == {f"{what}_{zone}{net}" for zone in ("edge", "crease") for what in ("rmse", "bias") for net in ("", "_net")} - {
        "bias_edge_net", "bias_crease_net"
    } | {f"share_{zone}" for zone in ZONES}  # fmt: skip
    assert all(got[k] == 0 for k in KEYS if k not in {"psnr", "ssim"} | nothing)


def test_background_counts_nowhere() -> None:
    truth, found = np.random.default_rng(1).random((2, *SHAPE))
    other = found.copy()
    other[:, 40:] = np.nan
    where = zones(edge=slice(35, 40), seen=slice(0, 40))
    one, two = measure(found, truth, where), measure(other, truth, where)
    np.testing.assert_equal(one, two)
    assert one["rmse"] == pytest.approx(np.sqrt(((found - truth)[:, :40] ** 2).mean()))
    assert one["rmse_edge"] == pytest.approx(np.sqrt(((found - truth)[:, 35:40] ** 2).mean()))


def test_nothing_to_measure_is_nan() -> None:
    assert all(np.isnan(v) for v in measure(GREY, GREY, zones(seen=slice(0, 0)), stderr=GREY).values())


def test_the_noise_of_the_truth_is_subtracted() -> None:
    """A method that is off by .1, against a truth whose pixels are off by .05 on their own."""
    random = np.random.default_rng(4)
    shape = (400, 400)
    right, stderr = np.full(shape, 0.5), np.full(shape, 0.05)
    truth = right + random.normal(0, 0.05, shape)
    where = zones(edge=slice(0, 100), crease=slice(100, 200), shape=shape)
    got = measure(right + 0.1, truth, where, stderr=stderr)
    assert got["rmse"] == pytest.approx(np.hypot(0.1, 0.05), rel=0.01)
    for key in ("rmse_net", *(f"rmse_{zone}_net" for zone in ZONES)):
        assert got[key] == pytest.approx(0.1, rel=0.01), key
    assert [got[f"share_{zone}"] for zone in ZONES] == pytest.approx([0.25, 0.25, 0.5], rel=0.02)
    # A method that is right has no error left, and no blotches: of the noise a known part is in their band.
    got = measure(right, truth, where, stderr=stderr)
    assert got["rmse_net"] < 0.01 < 0.05 < got["rmse"] * 1.02
    assert got["blotches"] == pytest.approx(0.05 * np.sqrt(0.0338), rel=0.1) and got["blotches_net"] < 0.4 * got["blotches"]
    assert net(0.03, stderr, where.seen) == 0  # never below nothing
    assert np.isnan(measure(right, truth, where)["rmse_net"])  # unknown noise is not none


def test_shares_of_the_squared_error() -> None:
    found = np.full(SHAPE, 0.5)
    found[:, :8] += 0.3
    found[:, 8:24] -= 0.1
    got = measure(found, GREY, zones(edge=slice(0, 8), crease=slice(8, 24)), stderr=0 * GREY)
    assert [got[f"share_{zone}"] for zone in ZONES] == pytest.approx([0.72 / 0.88, 0.16 / 0.88, 0])
    assert [got[f"bias_{zone}"] for zone in ZONES] == pytest.approx([0.3, -0.1, 0])
    assert [got[f"rmse_{zone}"] for zone in ZONES] == pytest.approx([0.3, 0.1, 0])


def test_noise_is_what_changes_from_pixel_to_pixel() -> None:
    random = np.random.default_rng(2)
    truth = np.full((200, 200), 0.6)
    flat = np.ones((200, 200), bool)
    assert noise(truth - 0.2, truth, flat) == pytest.approx(0, abs=1e-7)
    assert noise(truth + random.normal(0, 0.05, truth.shape), truth, flat) == pytest.approx(0.05, rel=0.02)
    tiled = np.tile(random.normal(0, 0.05, (4, 4)), (50, 50))
    assert noise(truth + tiled, truth, flat) == pytest.approx(tiled.std(), rel=0.1)
    at_edge = truth + np.where(np.abs(np.arange(200) - 99.5) < 4, 0.3, 0) * random.normal(size=truth.shape)
    assert noise(at_edge, truth, zones(edge=slice(96, 104), shape=(200, 200)).flat) == 0  # that is another zone's


def test_bands() -> None:
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
        measure(GREY, GREY[1:], zones())
    with pytest.raises(FormatError, match="not finite"):
        measure(np.full(SHAPE, np.nan), GREY, zones())
    where = np.ones(SHAPE, bool)
    for module, metric in (("skimage.metrics", ssim), ("flip_evaluator", flip)):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(SettingsError, match=r"pip install 'ssao_gl\[metrics\]'"):
            metric(GREY, GREY, where)
