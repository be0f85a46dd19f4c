"""Sizes that callers hand in."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.scene.projection import pixel_size


@pytest.mark.parametrize("size", [(64, 48), [64, 48], (64.0, 48.0), np.array([64, 48]), (np.int32(64), np.float64(48))])
def test_whole_sizes(size: Any) -> None:
    found = pixel_size(size)
    assert found == (64, 48) and all(type(side) is int for side in found)


@pytest.mark.parametrize(
    "size",
    [
        64,
        "64x48",
        ("64", "48"),
        (64,),
        (64, 48, 3),
        (64.5, 48),
        (0, 48),
        (-64, 48),
        (1 << 17, 48),
        (float("nan"), 48),
        (float("inf"), 1),
        None,
    ],
)
def test_no_sizes(size: Any) -> None:
    with pytest.raises(ao.SettingsError, match=r"must be \(width, height\) in whole pixels, sides from 1 to 65536"):
        pixel_size(size)


def test_names_and_sizes_of_a_picture(any_renderer: ao.Renderer, embedded: ao.Scene) -> None:
    """One name as plain text; sizes as floats."""
    picture = any_renderer.render(embedded, size=(64.0, 48.0), aovs="depth")  # type: ignore[arg-type]
    assert list(picture.arrays) == ["depth"] and picture.depth.shape == (48, 64) and picture.report["size"] == [64, 48]
    assert list(ao.render(embedded, size=(16, 12), aovs="depth, normal").arrays) == ["depth", "normal"]
