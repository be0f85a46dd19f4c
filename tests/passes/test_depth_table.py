"""The summed-area table of inverse depth: its entries are those of the image, its box sums exact whatever wraps."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import DEPTH, DEPTH_TABLE
from ssao_gl.passes.depth_table import STEP, depth_table
from ssao_gl.pipeline.build import plan_render
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene

from ..shapes import camera, plane

F64 = np.ndarray[Any, np.dtype[np.float64]]
SCALE = 4


def settings(**changes: Any) -> ao.Settings:
    return ao.Settings(method=dataclasses.replace(ao.method("vom"), radius=0.5, **changes))


def table_and_depth(renderer: ao.Renderer, scene: Scene, cam: Camera, size: tuple[int, int]) -> tuple[np.ndarray, F64]:
    """The table (rows, columns, 4) uint32, and the depth of the pixels that its texels stand for; row 0 at the bottom."""
    table, z = (renderer.resource(scene, cam, size, settings(), name) for name in (DEPTH_TABLE, DEPTH))
    assert table is not None and z is not None
    return table, z[::SCALE, ::SCALE, 0].astype(np.float64)


def entries(table: np.ndarray) -> np.ndarray:
    """What each texel added, from the differences of its neighbours' sums: modulo 2^32, as the sums are."""
    padded = np.pad(table.astype(np.int64), ((1, 0), (1, 0), (0, 0)))
    return (padded[1:, 1:] - padded[:-1, 1:] - padded[1:, :-1] + padded[:-1, :-1]) % 2**32


@pytest.mark.parametrize("projection", ["perspective", "parallel"])
@pytest.mark.parametrize("size", [(192, 144), (33, 17), (1, 1), (5, 300)])
def test_the_table_sums_what_the_image_shows(
    renderer: ao.Renderer, embedded: Scene, size: tuple[int, int], projection: str
) -> None:
    cam = embedded.cameras[0]
    cam = cam if projection == "perspective" else Camera.orthographic(5.0, 0.0, 30.0, cam.pose)
    table, z = table_and_depth(renderer, embedded, cam, size)
    assert table.shape == (-(-size[1] // SCALE), -(-size[0] // SCALE), 4)
    added, covered = entries(table), z > 0
    assert (added[..., 2] == covered).all()
    assert (added[~covered] == 0).all() and added.max() < 2**16
    if not covered.any():
        return
    near = (1 / z[covered]) if projection == "perspective" else -z[covered]
    share = (near - near.min()) / max(np.ptp(near), 1e-28)
    found = (added[covered, 0] + added[covered, 1] / 2**16) / 65535
    assert np.abs(found - share).max() < 1e-5  # 24 bits of nearness, and of their difference


def test_box_means_are_exact_where_sums_wrap(any_renderer: ao.Renderer) -> None:
    """A thousand boxes of a table whose sums pass 2^32 many times."""
    table, z = table_and_depth(any_renderer, plane(1.2), camera(), (2048, 1536))
    added = entries(table)
    assert (z > 0).any() and added[..., 0].sum() > 2**32  # they wrap
    random = np.random.default_rng(1)
    for _ in range(1000):
        h = random.integers(1, 127, 2)
        y, x = (random.integers(h[i] + 1, table.shape[i] - h[i]) for i in (0, 1))
        low, high = (y - h[0] - 1, x - h[1] - 1), (y + h[0], x + h[1])
        box = table[high] - table[low[0], high[1]] - table[high[0], low[1]] + table[low]  # in 32 bits
        assert (box == added[low[0] + 1 : high[0] + 1, low[1] + 1 : high[1] + 1].sum((0, 1))).all()


@pytest.mark.parametrize(
    ("size", "sums"), [((1280, 720), 5 + 4), ((4, 4), 1), ((16, 4), 1), ((17, 4), 2), ((16384, 16384), 12)]
)
def test_four_texels_a_pass(size: tuple[int, int], sums: int) -> None:
    """ceil(log4 W) + ceil(log4 H) passes, for the W x H texels of the table."""
    names = [task.name for task in depth_table(size, SCALE)]
    assert STEP == 4 and sum(name.startswith("sum") for name in names) == sums


def test_there_is_no_table_where_nobody_reads_it() -> None:
    size = (640, 360)
    for plan in (plan_render(settings(), size, ["depth"]), plan_render(ao.Settings(method=ao.Bitmask(radius=1)), size)):
        assert not any(step.task.name.startswith(("sum", "depth range")) for step in plan.steps)
    with_table = plan_render(settings(), size)
    assert DEPTH_TABLE in with_table.where
    sums = [step for step in with_table.steps if step.task.name.startswith("sum")]
    assert len({slot for step in sums for slot in step.slots}) == 2  # they take turns
