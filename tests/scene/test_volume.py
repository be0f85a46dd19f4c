"""Volumes as arrays: what is refused, their box, their levels, the field and its bricks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import InputWarning, SceneError
from ssao_gl.scene.proximity import INSIDE, proximity
from ssao_gl.scene.transfer import Transfer, TransferPoint

from ..volumes import ball, slab

RAMP = np.arange(24.0).reshape(2, 3, 4)
SINGULAR = np.diag([1.0, 1.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("array", "options", "told"),
    [
        (np.zeros((3, 4)), {}, "must be an array (x, y, z)"),
        (np.zeros((3, 4, 0)), {}, "must be an array (x, y, z)"),
        (np.zeros((3, 4, 5, 6)), {}, "array[..., 0]"),
        (np.zeros((3, 4, 5), complex), {}, "expected real numbers"),
        (np.full((3, 4, 5), np.nan), {}, "not one voxel is a finite number"),
        (np.full((3, 4, 5), 7.0), {"iso": 7.0}, "all voxels are 7"),
        (np.full((1, 1, 1), 7.0), {"iso": 3.0}, "all voxels are 7"),
        (RAMP, {"iso": 24.0}, "at most 23"),
        (RAMP, {"iso": 0.0}, "above 0"),
        (RAMP, {"iso": np.nan}, "above 0"),
        (RAMP, {"affine": SINGULAR}, "singular"),
        (RAMP, {"affine": np.eye(3)}, "(4, 4)"),
        (RAMP, {"affine": np.full((4, 4), np.inf)}, "(4, 4)"),
        (RAMP, {"iso": 3.0, "transfer": Transfer([TransferPoint(0, 1)])}, "give one"),
        (np.array([-1e308, 1e308] * 4).reshape(2, 2, 2), {}, "span more than 64-bit"),
    ],
)
def test_what_has_no_surface_is_refused_in_a_line(array: Any, options: dict[str, Any], told: str) -> None:
    with pytest.raises(SceneError) as error:
        ao.Volume(array, **options)
    assert told in str(error.value) and "\n" not in str(error.value)


def test_voxels_that_are_no_numbers_count_as_empty() -> None:
    values = RAMP.copy()
    values[1, 2, 3], values[0, 0, 1] = np.nan, np.inf
    with pytest.warns(InputWarning, match="2 of 24 voxels"):
        volume = ao.Volume(values, iso=3.0)
    assert volume.array[1, 2, 3] == volume.array[0, 0, 1] == volume.range[0] == 0


def test_the_box_is_that_of_what_is_inside() -> None:
    volume = ball(0.5, 48, (3, 4, 5))
    assert (np.abs(volume.bounds - [[2.5, 3.5, 4.5], [3.5, 4.5, 5.5]]) < 1.5 * volume.voxel).all()
    assert (volume.bounds[0] <= [2.5, 3.5, 4.5]).all() and (volume.bounds[1] >= [3.5, 4.5, 5.5]).all()


def test_the_field_keeps_each_voxel_on_its_side() -> None:
    values = np.random.default_rng(1).integers(0, 65536, (9, 8, 7)).astype(np.uint16)
    values[0, 0, :2] = 999, 1000
    for volume in (
        ao.Volume(values, iso=1000.0),
        ao.Volume(values * 1e-300, iso=1e-297),
        ao.Volume(values + 2.0**40, iso=2.0**40 + 1000),
    ):
        inside = volume.field[1:-1, 1:-1, 1:-1].transpose(2, 1, 0) >= 0
        assert np.array_equal(inside, values >= 1000)
        assert np.abs(volume.field).max() == 1 and (volume.field[0] < 0).all()


@pytest.mark.parametrize("make", [lambda: ball(1.0, 40), lambda: slab(0.5, n=20)], ids=["iso", "transfer"])
def test_leaps_end_before_the_surface(make: Any) -> None:
    volume = make()
    leaps, field = proximity(volume), volume.field
    seen = field >= 0 if volume.iso is not None else volume.transfer_of().opaque(field)
    assert leaps.shape == tuple(n - 1 for n in field.shape) and (leaps % INSIDE == 0).any() and (leaps % INSIDE > 3).any()
    for cell in np.random.default_rng(4).integers(0, leaps.shape, (400, 3)):
        away = int(leaps[tuple(cell)]) % INSIDE
        block = seen[tuple(slice(max(c - away + 1, 0), c + away + 1) for c in cell)]
        assert away == 0 or (block.all() if leaps[tuple(cell)] >= INSIDE else not block.any())
        wider = seen[tuple(slice(max(c - away, 0), c + away + 2) for c in cell)]
        assert away == 0 or wider.any() != wider.all() or volume.iso is None


def test_a_level_of_its_own_parts_two_kinds_of_voxels() -> None:
    values = np.random.default_rng(2).normal(100, 3, (12, 12, 12))
    values[4:8, 4:8, 4:8] += 100
    volume = ao.Volume(values)
    assert volume.iso is not None and 112 < volume.iso < 185
    assert ao.Volume(np.array([0, 0, 0, 5], np.uint8).reshape(1, 2, 2)).iso is not None


def test_transfer_functions_are_linear_between_their_points() -> None:
    made = Transfer([TransferPoint(10, 0.2, (1, 0, 0)), TransferPoint(30, 1.0, (0, 0, 1))]).over(0, 40)
    table = made.table()
    np.testing.assert_allclose(table[[0, 255]], [[1, 0, 0, 0.2], [0, 0, 1, 1.0]], atol=1e-6)
    np.testing.assert_allclose(np.interp(0.5, np.linspace(0, 1, len(table)), table[:, 3]), 0.6, atol=4e-3)


@pytest.mark.parametrize(
    ("points", "options", "told"),
    [
        ([], {}, "0 points"),
        ([TransferPoint(0, 2.0)], {}, "0 to 1"),
        ([TransferPoint(np.nan, 0.5)], {}, "finite"),
        ([TransferPoint(2, 0.5), TransferPoint(1, 0.5)], {}, "must grow"),
        ([TransferPoint(0, 1.0)], {"unit": 0.0}, "above 0"),
        ([TransferPoint(0, 1.0)], {"step": 9.0}, "0.05 to 4"),
    ],
)
def test_transfer_functions_that_make_no_sense_are_refused(points: Any, options: dict[str, Any], told: str) -> None:
    with pytest.raises(SceneError, match=told):
        Transfer(points, **options)
