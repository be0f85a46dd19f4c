"""Rays are scattered evenly, as many as are asked for, and by their place in the whole picture alone."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.sampling.scatter import has_ray, ray_layers, sobol_pairs, z_order

SIZE = (64, 64)


def traced(share: float, corner: tuple[int, int] = (0, 0), size: tuple[int, int] = SIZE) -> np.ndarray:
    """Rays of each pixel (h, w)."""
    count = np.zeros(size[0] * size[1], int)
    for layer in ray_layers(corner, size, SIZE, share):
        assert len(np.unique(layer.pixel)) == len(layer.pixel), "no pixel twice in a layer"
        count[layer.pixel] += 1
    return count.reshape(size[::-1])


@pytest.mark.parametrize(("share", "side"), [(1 / 4, 2), (1 / 16, 4), (1 / 64, 8)])
def test_a_share_is_one_pixel_of_each_block(share: float, side: int) -> None:
    blocks = traced(share).reshape(64 // side, side, 64 // side, side).sum((1, 3))
    assert (blocks == 1).all()
    places = {
        tuple(np.argwhere(b)[0])
        for b in traced(share).reshape(64 // side, side, 64 // side, side).swapaxes(1, 2).reshape(-1, side, side)
    }
    assert len(places) > side * side / 2, "scattered: not the same place in every block"


@pytest.mark.parametrize("share", [0.001, 0.1, 0.3, 0.5, 0.7, 0.99, 1.0, 1.25, 3.0, 4.6])
def test_as_many_rays_as_are_asked_for(share: float) -> None:
    count = traced(share)
    assert abs(count.sum() - share * count.size) <= 1 and count.max() - count.min() <= 1
    assert count.min() == int(share)


def test_a_part_has_the_rays_of_the_whole_and_none_beside_it() -> None:
    whole = traced(0.3)
    part = traced(0.3, (-5, 20), (40, 60))
    assert (part[:44, 5:] == whole[20:64, :35]).all() and not part[44:].any() and not part[:, :5].any()
    layers = [next(ray_layers(corner, (20, 20), SIZE, 0.3)) for corner in ((10, 10), (14, 12))]
    ways = [np.full((20 * 20, 3), np.nan) for _ in layers]
    for way, layer in zip(ways, layers, strict=True):
        way[layer.pixel] = layer.direction.T
    one, other = (way.reshape(20, 20, 3) for way in ways)
    assert np.array_equal(one[2:, 4:], other[:18, :16], equal_nan=True)


def test_neighbours_have_points_of_one_net() -> None:
    """In aligned blocks of 2^k pixels along the curve, every elementary interval of area 2^-k has one point."""
    points = sobol_pairs(np.arange(1024, dtype=np.uint32), (0x12345678, 0x9ABCDEF0))
    for start in range(0, 1024, 64):
        for a in range(7):
            cell = np.floor(points[0, start : start + 64] * 2**a) * 2 ** (6 - a) + np.floor(
                points[1, start : start + 64] * 2 ** (6 - a)
            )
            assert len(np.unique(cell)) == 64


def test_directions_are_unit_and_cosine_weighted() -> None:
    layer = next(ray_layers((0, 0), SIZE, SIZE, 1.0))
    assert np.abs(np.linalg.norm(layer.direction, axis=0) - 1).max() < 1e-6 and layer.direction[2].min() > 0
    assert layer.direction[2].mean() == pytest.approx(2 / 3, abs=2e-3) and np.abs(layer.direction[:2].mean(1)).max() < 2e-3


def test_z_order_is_a_numbering() -> None:
    y, x = np.indices((32, 32))
    order = z_order(x, y)
    assert sorted(order.ravel()) == list(range(1024)) and order[0, 1] == 1 and order[1, 0] == 2
    assert has_ray(order, 1.0).all()
