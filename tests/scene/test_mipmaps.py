"""Smaller copies of textures: sizes, means of light, none left out."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.scene import mipmaps
from ssao_gl.scene.mipmaps import smaller_copies
from ssao_gl.scene.srgb import decode


@pytest.mark.parametrize("size", [(8, 8), (63, 127), (1, 5), (6, 10), (1, 1)])
def test_sizes_halve_down_to_one_texel(size: tuple[int, int]) -> None:
    h, w = size
    expected = []
    while (h, w) != (1, 1):
        h, w = max(h // 2, 1), max(w // 2, 1)
        expected.append((h, w, 3))
    assert [copy.shape for copy in smaller_copies(np.zeros((*size, 3), np.uint8))] == expected


@pytest.mark.parametrize("size", [(63, 127), (64, 48), (5, 7)])
def test_the_mean_light_stays(size: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    """Of colours in linear light, of alpha as it is; in strips too."""
    texels = np.random.default_rng(3).integers(0, 256, (*size, 4)).astype(np.uint8)
    copies = list(smaller_copies(texels))
    np.testing.assert_allclose(
        decode(copies[0][..., :3] / 255).mean((0, 1)), decode(texels[..., :3] / 255).mean((0, 1)), atol=2e-3
    )
    assert abs(copies[0][..., 3].mean() - texels[..., 3].mean()) < 0.5
    monkeypatch.setattr(mipmaps, "CHUNK", 4 * size[1])
    assert all(np.array_equal(a, b) for a, b in zip(copies, smaller_copies(texels), strict=True))


def test_each_texel_of_an_odd_row_counts_alike() -> None:
    """One white texel of seven gives a seventh of the light, wherever it is."""
    for at in range(7):
        row = np.zeros((1, 7, 3), np.uint8)
        row[0, at] = 255
        first = next(smaller_copies(row))
        assert decode(first[..., 0] / 255).mean() == pytest.approx(1 / 7, abs=3e-3)
