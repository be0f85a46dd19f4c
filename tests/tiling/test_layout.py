"""Tiles: how a picture is cut, what a tile's camera sees, and how far pixels depend on each other. No OpenGL."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ssao_gl as ao
from ssao_gl.errors import SettingsError
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lens import CropLens
from ssao_gl.tiling import layout as tiles
from ssao_gl.tiling.layout import Layout, layout

from ..scene.test_camera import LENSES, SIZE
from ..shapes import camera, plane

SETTINGS = ao.Settings(method=ao.Alchemy(radius=0.5))
VISIBILITY = ("visibility",)


@settings(deadline=None)
@given(st.tuples(*[st.integers(1, 700)] * 2), st.tuples(*[st.integers(1, 12)] * 2), st.integers(0, 10))
def test_tiles_cover_the_picture_once_with_their_halos(size: tuple[int, int], side: tuple[int, int], halo: int) -> None:
    made = Layout(size, (16 * side[0], 16 * side[1]), 16 * halo, 16 * halo)
    count = np.zeros(size[::-1], int)
    for tile in made.tiles():
        a, b = tile.inner, tile.outer
        count[a.y : a.y + a.h, a.x : a.x + a.w] += 1
        for low, span, start, length, whole in ((a.x, a.w, b.x, b.w, size[0]), (a.y, a.h, b.y, b.h, size[1])):
            assert start % 16 == 0, "the noise goes on"
            assert start == max(low - 16 * halo, 0) and start + length == min(low + span + 16 * halo, whole)
        assert b.w <= made.outer[0] and b.h <= made.outer[1]
    assert (count == 1).all()
    assert len(made.tiles()) == made.columns * made.rows == made.table()["count"]


@settings(deadline=None)
@given(st.integers(1, 300), st.integers(1, 10), st.integers(0, 10), st.integers(0, 5), st.sampled_from([16, 32, 48]))
def test_a_guard_is_drawn_around_the_picture(size: int, side: int, halo: int, guard: int, step: int) -> None:
    """And everything starts at multiples of the step from its corner, as in the whole picture."""
    made = Layout((size, size), (step * side, step * side), step * halo, step * halo, 16 * guard, step)
    for tile in made.tiles():
        low, high = (
            max(tile.inner.x - step * halo, -16 * guard),
            min(tile.inner.x + tile.inner.w + step * halo, size + 16 * guard),
        )
        assert low - step < tile.outer.x <= low and (tile.outer.x + 16 * guard) % step == 0
        assert tile.outer.x >= -16 * guard and tile.outer.x + tile.outer.w == high


def test_tiles_come_from_the_top_and_crop_what_they_add() -> None:
    made = Layout((40, 50), (16, 32), 16, 16)
    whole = np.arange(40 * 50).reshape(50, 40)
    rows, row = [], []
    for tile in made.tiles():
        top = 50 - tile.outer.y - tile.outer.h
        drawn = whole[top : top + tile.outer.h, tile.outer.x : tile.outer.x + tile.outer.w]
        row.append(tile.crop(drawn))
        if len(row) == made.columns:
            rows.append(np.concatenate(row, 1))
            row = []
    np.testing.assert_array_equal(np.concatenate(rows), whole)


@pytest.mark.parametrize("name", LENSES)
def test_a_part_shows_the_same_points_in_the_same_pixels(name: str) -> None:
    whole = LENSES[name].view(SIZE)
    corner, size = (96, 32), (80, 50)
    part = Camera(CropLens(LENSES[name].lens, SIZE, corner)).view(size)
    z = np.random.default_rng(1).uniform(1, 20, SIZE[::-1])
    top, left = SIZE[1] - corner[1] - size[1], corner[0]
    there = slice(top, top + size[1]), slice(left, left + size[0])
    np.testing.assert_allclose(part.points(z[there]), whole.points(z)[there], atol=1e-9)
    if name != "oblique near plane":  # which lies at another distance in the middle of the part
        assert (part.near, part.far) == pytest.approx((whole.near, whole.far), rel=1e-9)
    assert part.pixel == pytest.approx(whole.pixel) and part.whole == SIZE and whole.whole is None


def test_the_far_plane_of_a_small_part_of_a_huge_picture_stays_infinite() -> None:
    whole = (65536, 65536)
    for corner in ((0, 0), (65520, 0), (32768, 65520)):
        part = Camera(CropLens(Camera.perspective(0.9, 1e-3).lens, whole, corner)).view((16, 16))
        assert math.isinf(part.far) and part.near == pytest.approx(1e-3)


def test_reach_in_pixels() -> None:
    """Of a radius of 0.5: by the size of a pixel, on the nearest surface, as long as the method does not clamp it."""
    method = ao.Alchemy(radius=0.5, max_radius=4096)
    parallel = Camera.orthographic(4.0, 0.0, 30.0).view((300, 200))
    assert tiles.tap_reach(method, parallel, 3.0) == pytest.approx(0.5 * 50 + 1)
    narrow = Camera.perspective(4e-3, 1.0).view((200, 200))
    assert tiles.tap_reach(method, narrow, 10.0) == pytest.approx(0.5 * 100 / 2e-3 / 9.5 + 1, rel=1e-3)  # 0.5 nearer still
    assert tiles.tap_reach(dataclasses.replace(method, max_radius=64), narrow, 10.0) == 65
    assert tiles.tap_reach(dataclasses.replace(method, max_radius=64), narrow, 0.0) == 65, "no surface is too near"
    wide = Camera.perspective(math.pi / 2, 1.0).view((200, 200))
    assert tiles.tap_reach(method, wide, 10.0) == pytest.approx(0.5 * 100 * math.sqrt(3) / 9.5 + 1), "longer in the corners"
    assert tiles.tap_reach(ao.Lecture(radius=0.08), wide, 10.0) == pytest.approx(16), "a share of the image"
    assert tiles.tap_reach(ao.method("reference").__class__(radius=0.5, max_steps=100), wide, 0.1) == 101


@pytest.mark.parametrize("size", [(200, 200), (2000, 2000)])
def test_the_clamp_in_pixels_holds_at_any_size(size: tuple[int, int]) -> None:
    settings = ao.Settings(method=ao.Alchemy(radius=100.0, max_radius=64), blur=ao.Joint(radius=3))
    assert tiles.halo(plane(), camera(), size, settings) == 65 + 2 * 3 + 4
    assert tiles.halo(plane(), camera(), size, dataclasses.replace(settings, blur=None)) == 65 + 4


def test_nearest_is_of_the_scene_or_of_the_near_plane() -> None:
    wall = camera(pose=ao.look_at((0, 0, 1), (0, 0, 0)))
    assert tiles.nearest(plane(), wall, (64, 64)) == pytest.approx(6)
    assert tiles.nearest(plane(1.2), wall, (64, 64)) == pytest.approx(0.1)


def test_pictures_that_fit_stay_whole() -> None:
    assert layout(plane(), camera(), (1280, 720), SETTINGS, VISIBILITY) is None
    assert layout(plane(), camera(), (4096, 4096), SETTINGS, VISIBILITY, limit=4096) is None


@pytest.mark.parametrize("size", [(4097, 64), (64, 5000), (9999, 9999)])
def test_pictures_beyond_the_limit_are_cut_in_equal_parts(size: tuple[int, int]) -> None:
    cut = layout(plane(), camera(), size, SETTINGS, VISIBILITY, limit=4096)
    assert cut is not None and max(cut.outer) <= 4096 and cut.halo == cut.wanted
    for whole, side, count in zip(size, cut.side, (cut.columns, cut.rows), strict=True):
        assert side % 16 == 0 and whole > side * (count - 1) and side < whole / count + 16


def test_pictures_beyond_the_budget_are_cut_though_the_driver_could() -> None:
    cut = layout(plane(), camera(), (16384, 16384), SETTINGS, VISIBILITY, limit=1 << 20)
    assert cut is not None
    assert plan_render(SETTINGS, cut.outer, VISIBILITY).bytes <= tiles.TILE_BYTES


def test_arrays_without_occlusion_need_no_halo() -> None:
    for aovs, halo in ((("depth", "normal", "color"), 0), (("depth", "image"), 272)):
        cut = layout(plane(), camera(), (20000, 20000), SETTINGS, aovs)
        assert cut is not None and cut.halo == halo


def test_tiles_follow_the_noise() -> None:
    odd = ao.Settings(method=ao.Alchemy(radius=0.5, tile=5, max_radius=32))
    cut = layout(plane(), camera(), (500, 300), odd, VISIBILITY, tile=64)
    assert cut is not None and cut.side == (80, 80) and cut.halo % 80 == 0


def test_a_reach_over_the_largest_halo_is_cut_and_said() -> None:
    far = ao.Settings(method=ao.Lecture(radius=2.0))
    cut = layout(plane(), camera(), (32768, 32768), far, VISIBILITY)
    assert cut is not None and cut.halo == tiles.LARGEST_HALO < cut.wanted and "seams may show" in cut.describe()
    fits = layout(plane(), camera(), (32768, 32768), SETTINGS, VISIBILITY)
    assert fits is not None and "seams" not in fits.describe()


@pytest.mark.parametrize("tile", [-5, 0, 1, 63])
def test_tiny_tiles_are_refused(tile: int) -> None:
    with pytest.raises(SettingsError, match=f"--tile {tile}: must be at least 64 pixels"):
        layout(plane(), camera(), (640, 360), SETTINGS, VISIBILITY, tile=tile)


def test_tiles_over_the_limit_are_refused_with_what_would_do() -> None:
    with pytest.raises(SettingsError, match="draws at most 1024 a side; use at most ") as refusal:
        layout(plane(), camera(), (5000, 5000), SETTINGS, VISIBILITY, tile=1024, limit=1024)
    most = int(str(refusal.value).rsplit(" ", 1)[1])
    cut = layout(plane(), camera(), (5000, 5000), SETTINGS, VISIBILITY, tile=most, limit=1024)
    assert cut is not None and max(cut.outer) <= 1024
    with pytest.raises(SettingsError, match="use at most"):
        layout(plane(), camera(), (5000, 5000), SETTINGS, VISIBILITY, tile=most + 16, limit=1024)


def test_a_radius_that_is_not_settled_is_refused() -> None:
    with pytest.raises(SettingsError, match="must be settled"):
        tiles.tap_reach(ao.Alchemy(), camera().view((64, 64)), 1.0)
