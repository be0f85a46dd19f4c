"""What spheres, volumes and triangles fill, against counting."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ssao_gl.occupancy.field import field_of
from ssao_gl.occupancy.grid import grid_over
from ssao_gl.occupancy.meshes import fill_mesh
from ssao_gl.occupancy.spheres import fill_spheres
from ssao_gl.occupancy.volumes import fill_volume
from ssao_gl.scene.material import Material
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.spheres import Spheres

from ..shapes import quad
from ..volumes import ball


def middles(grid: object) -> np.ndarray:
    """Middles of voxels in the world (z, y, x, 3)."""
    index = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing="ij"), -1)[..., ::1] + 0.5  # type: ignore[attr-defined]
    return (grid.low + grid.side * index).transpose(2, 1, 0, 3)  # type: ignore[attr-defined]


@pytest.mark.parametrize("side", [0.09, 0.4])
def test_spheres_fill_what_lies_within_them(side: float) -> None:
    """Small and large beside a voxel, as instances; to a voxel of the edge."""
    rng = np.random.default_rng(5)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = 1.5 * turn, (2, 0.3, 0)
    spheres = Spheres(
        rng.normal(size=(6, 3)).astype(np.float32), rng.uniform(0.1, 0.6, 6), transforms=np.stack([np.eye(4), place])
    )
    grid = grid_over(spheres.bounds, side)
    voxels = np.zeros(grid.shape[::-1], np.uint8)
    fill_spheres(voxels, grid, spheres)
    at, far = middles(grid), np.full(grid.shape[::-1], -np.inf)
    for matrix, scale in zip(spheres.transforms, (1.0, 1.5), strict=True):
        for center, radius in zip(spheres.centers @ matrix[:3, :3].T + matrix[:3, 3], spheres.radii, strict=True):
            far = np.maximum(far, scale * radius - np.linalg.norm(at - center, axis=-1))
    exact = 255 * np.clip(0.5 + 2 * far / side, 0, 1)
    assert np.abs(voxels - exact).max() <= 1.5 and (voxels == 255).any()


def test_spheres_of_radius_0_fill_nothing() -> None:
    spheres = Spheres(np.zeros((2, 3), np.float32), np.array([0, 1], np.float32))
    grid = grid_over(spheres.bounds, 0.5)
    some, none = (np.zeros(grid.shape[::-1], np.uint8) for _ in range(2))
    fill_spheres(some, grid, spheres)
    fill_spheres(none, grid, Spheres(np.zeros((1, 3), np.float32), np.float32(0)))
    assert some.any() and not none.any()


@pytest.mark.parametrize("center", [(0, 0, 0), (30, -20, 5)])
def test_a_volume_fills_the_space_of_its_ball(center: tuple[float, float, float]) -> None:
    volume = ball(1.0, 48, center)
    grid = grid_over(volume.bounds, 0.05)
    voxels = np.zeros(grid.shape[::-1], np.uint8)
    fill_volume(voxels, grid, volume)
    assert voxels.sum() / 255 * grid.side**3 == pytest.approx(4 / 3 * math.pi, rel=0.01)
    inside = np.linalg.norm(middles(grid) - center, axis=-1)
    assert (voxels[inside < 0.9] == 255).all() and (voxels[inside > 1.1] == 0).all()


def test_triangles_fill_every_voxel_that_they_go_through() -> None:
    mesh = quad((0.1, 0.2, 0.3), (2, 0, 0.5), (0, 1.5, -0.7))
    grid = grid_over(mesh.bounds, 0.11)
    voxels = np.zeros(grid.shape[::-1], np.uint8)
    fill_mesh(voxels, grid, mesh)
    u, v = np.random.default_rng(1).uniform(-1, 1, (2, 20000, 1))
    points = np.array([0.1, 0.2, 0.3]) + u * [2, 0, 0.5] + v * [0, 1.5, -0.7]
    x, y, z = np.floor((points - grid.low) / grid.side).astype(int).T
    assert (voxels[z, y, x] == 255).mean() > 0.99, "but for corners that points pass by"
    off = np.abs(
        (middles(grid) - [0.1, 0.2, 0.3])
        @ np.cross([2, 0, 0.5], [0, 1.5, -0.7])
        / np.linalg.norm(np.cross([2, 0, 0.5], [0, 1.5, -0.7]))
    )
    assert (voxels[off > 0.87 * grid.side] == 0).all()


def test_what_alpha_cuts_out_fills_nothing() -> None:
    whole, colors = quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), np.full((4, 4), 255, np.uint8)
    colors[whole.positions[:, 0] < 0, 3] = 0
    cut = dataclasses.replace(whole, vertex_colors=colors, material=Material(alpha_mode="MASK"))
    grid = grid_over(whole.bounds, 0.2)
    solid, holed = (np.zeros(grid.shape[::-1], np.uint8) for _ in range(2))
    fill_mesh(solid, grid, whole)
    fill_mesh(holed, grid, cut)
    x = middles(grid)[..., 0]
    assert (holed[x > 0.2] == solid[x > 0.2]).all() and not holed[x < -0.2].any() and solid[x < -0.2].any()


def test_spheres_of_radius_0_do_not_count() -> None:
    centers = np.zeros((2, 3), np.float32)
    alone, beside = (field_of(Scene(spheres=[Spheres(centers[: len(r)], np.array(r, np.float32))]), 0.5) for r in ([1], [1, 0]))
    assert alone.apart == beside.apart > 0 and (alone.finest == beside.finest).all()


def test_all_of_a_scene_is_in_one_field() -> None:
    mesh, spheres = quad((0, 0, -3), (1, 0, 0), (0, 1, 0)), Spheres(np.array([[5, 0, 0]], np.float32), np.float32(1))
    field = field_of(Scene([mesh], spheres=[spheres], volumes=[ball(1.0, 24, (0, 5, 0))]), 0.25)
    for point in ((0, 0, -3), (5, 0, 0), (0, 5, 0)):
        x, y, z = np.floor((np.array(point) - field.grid.low) / field.grid.side).astype(int)
        assert field.finest[z, y, x] == 255
    assert field.bytes == field.finest.nbytes + field.coarser.nbytes and isinstance(mesh, Mesh)
