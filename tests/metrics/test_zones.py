"""Zones of depth and normals whose edges and creases are known."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl import Camera
from ssao_gl.errors import FormatError
from ssao_gl.metrics.zones import ZONES, dilated, zones_of
from ssao_gl.scene.projection import ViewConstants

W, H = 80, 60
VIEW = Camera.orthographic(6.0, 0.1, 100.0).view((W, H))
LENS = Camera.perspective(1.0, 0.1, 100.0).view((W, H))
COLUMN = np.arange(W) * np.ones((H, 1))
FRONT = np.broadcast_to([0.0, 0.0, 1.0], (H, W, 3))


def columns(mask: np.ndarray) -> list[int]:
    assert (mask == mask[:1]).all()
    return np.flatnonzero(mask[0]).tolist()


def plane(view: ViewConstants, normal: np.ndarray, offset: float) -> tuple[np.ndarray, np.ndarray]:
    """Depth of the points p with ``normal . p = offset``, 0 behind the eye, and its normals towards the eye."""
    rays, starts = view.points(np.ones((H, W))), view.points(np.zeros((H, W)))
    depth = (offset - starts @ normal) / ((rays - starts) @ normal)
    return np.where(depth > 0, depth, 0), np.broadcast_to(normal * -np.sign(offset), (H, W, 3))


@pytest.mark.parametrize("view", [VIEW, LENS])
def test_a_step_is_an_edge_beyond_a_quarter_of_the_radius(view: ViewConstants) -> None:
    deep = zones_of(np.where(COLUMN < 40, 2.0, 2.3), FRONT, view, 1.0)
    assert columns(deep.edge) == list(range(36, 44)) and not deep.crease.any() and deep.shares()["flat"] == 0.9
    assert zones_of(np.where(COLUMN < 40, 2.0, 2.2), FRONT, view, 1.0).flat.all()
    assert columns(zones_of(np.where(COLUMN < 40, 2.0, 2.2), FRONT, view, 0.5).edge) == list(range(36, 44))


@pytest.mark.parametrize(("view", "offset"), [(VIEW, -4.0), (LENS, -1.0)])
def test_a_steep_floor_is_flat(view: ViewConstants, offset: float) -> None:
    """Its depth changes from row to row by more than a quarter of the radius, but no pixel is off another's plane."""
    floor, normals = plane(view, np.array([0.0, 0.999, 0.0447]), offset)
    floor[:34] = 0
    assert (-np.diff(floor[34:, 0])).max() > 0.25 * 0.25 and (floor[34:] > 0).all()
    found = zones_of(floor, normals, view, 0.25)
    # The edge is where the background begins.
    assert not found.crease.any() and found.edge[34:38].all() and found.flat[38:].all()
    # With normals that are not the floor's it is all edges: depth alone would say so.
    assert zones_of(floor, FRONT, view, 0.25).edge[34:44].all()


def test_background_makes_silhouettes() -> None:
    hole = np.full((H, W), 2.0)
    hole[30, 40] = np.inf
    found = zones_of(hole, FRONT, VIEW, 1.0)
    # The four neighbours are beside the edge; 3 pixels about each and about the hole itself.
    assert found.edge.sum() == 7 * 9 + 2 * 7 - 1 and found.edge[30, 36] and not found.edge[26, 36] and not found.seen[30, 40]


def test_normals_that_turn_are_creases_unless_at_an_edge() -> None:
    bent = np.where((COLUMN < 20)[..., None], [np.sin(0.4), 0.0, np.cos(0.4)], FRONT)
    found = zones_of(np.full((H, W), 2.0), bent, VIEW, 9.0)
    assert columns(found.crease) == list(range(17, 23)) and not found.edge.any()
    little = np.where((COLUMN < 20)[..., None], [np.sin(0.3), 0.0, np.cos(0.3)], FRONT)  # 17 degrees
    assert zones_of(np.full((H, W), 2.0), little, VIEW, 9.0).flat.all()
    both = zones_of(np.where(COLUMN < 22, 2.0, 3.0), bent, VIEW, 1.0)
    assert columns(both.edge) == list(range(18, 26)) and columns(both.crease) == [17]


def test_every_pixel_is_in_one_zone() -> None:
    random = np.random.default_rng(0)
    depth = random.choice([0.0, np.nan, 2.0, 2.1, 4.0], (H, W))
    normals = random.normal(size=(H, W, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    seen = random.random((H, W)) < 0.9
    found = zones_of(depth, normals, LENS, 1.0, seen)
    count = sum(getattr(found, zone).astype(int) for zone in ZONES)
    assert (count == (seen & (depth > 0))).all() and (found.seen == (count == 1)).all()
    assert sum(found.shares().values()) == pytest.approx(1)


def test_nothing_and_single_pixels() -> None:
    nothing = zones_of(np.zeros((H, W)), FRONT, VIEW, 1.0)
    assert not nothing.seen.any() and all(np.isnan(share) for share in nothing.shares().values())
    one = Camera.orthographic(1.0, 0.1, 10.0).view((1, 1))
    assert zones_of([[2.0]], [[[0.0, 0.0, 1.0]]], one, 1.0).flat.all()


def test_shapes_that_do_not_fit() -> None:
    with pytest.raises(FormatError, match=r"zones: depth \(59, 80\)"):
        zones_of(np.ones((H - 1, W)), FRONT, VIEW, 1.0)


def test_dilation_is_a_square() -> None:
    one = np.zeros((20, 20), bool)
    one[10, 3] = True
    assert np.argwhere(dilated(one, 4)).min(0).tolist() == [6, 0] and dilated(one, 4).sum() == 9 * 8
