"""Occlusion by disks, against closed forms and against rays."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.bake.elements import Elements, _joined, disks_of, elements
from ssao_gl.bake.settings import Baking, OcclusionTexture
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.sample_scene import default_scene
from ssao_gl.truth.rays import RayScene

pytest.importorskip("numba")
pytest.importorskip("embreex")

UP = np.array([[0.0, 0.0, 1.0]])
HERE = np.zeros((1, 3))


def one_disk(height: float, radius: float, *, gems: bool = False, reach: float = 2.0) -> Elements:
    """Made by hand, in a grid of one cell."""
    disk = np.array([[0, 0, height, 0, 0, -1, math.pi * radius**2]])
    return Elements(disk, np.ones((1, 1)), np.array([0, 1]), 2.0, 1, reach, gems)


def plate(height: float, half: float = 0.5) -> Mesh:
    corners = np.array([[-half, -half, height], [half, -half, height], [half, half, height], [-half, half, height]], np.float32)
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))


def above_the_middle(settings: Baking, *things: Mesh) -> float:
    """What meshes take of the hemisphere of the middle of the ground, which lies ``1`` below their origin."""
    rays = RayScene(Scene([*things, plate(-9, 1e-3)]))  # a mote, so that the place of the ground is within the grid
    point = ((HERE + [0, 0, -1]) - rays.center) * rays.scale
    return float(elements(rays, settings).occlusion(point, UP)[0, 0].mean())


@pytest.mark.parametrize("radius", [0.01, 0.3, 1.0, 3.0])
def test_a_disk_is_exact_on_its_axis(radius: float) -> None:
    """a^2 / (a^2 + h^2), the form factor of a disk."""
    found = one_disk(0.5, radius).occlusion(HERE, UP)[0]
    assert found[0, 0] == pytest.approx(radius**2 / (radius**2 + 0.25), rel=1e-12) and found[1, 0] == 0


@pytest.mark.parametrize("radius", [0.01, 0.3, 1.0, 3.0])
def test_the_kernel_of_the_book_is_the_solid_angle(radius: float) -> None:
    """1 - 1 / sqrt(1 + a^2 / h^2): .293 where the form factor is .5. This deviation is the book's."""
    found = one_disk(0.5, radius, gems=True).occlusion(HERE, UP)[0, 0, 0]
    assert found == pytest.approx(1 - 1 / math.sqrt(1 + radius**2 / 0.25), rel=1e-12)


def test_what_lies_beyond_the_radius_takes_nothing_and_what_lies_behind_is_behind() -> None:
    assert one_disk(0.5, 0.3, reach=0.5).occlusion(HERE, UP).max() == 0
    behind = one_disk(-0.5, 0.3).occlusion(HERE, UP)[0, :, 0]
    assert behind[0] == 0 and behind[1] > 0


def test_a_plate_is_exact_however_it_is_cut() -> None:
    """A square above a point, as disks of its pieces: four times the form factor of a rectangle seen from below its corner."""
    half, height = 0.5, 1.0
    x = half / height
    corner = 2 * x / math.sqrt(1 + x * x) * math.atan(x / math.sqrt(1 + x * x)) / (2 * math.pi)
    for radius in (1.5, 4.0):
        found = above_the_middle(Baking(radius=radius, passes=1), plate(0.0))
        assert found == pytest.approx(4 * corner, abs=0.01)


def test_two_plates_darken_nearly_as_one_does() -> None:
    """The second is hidden by the first. One pass counts both; with three, plates as small as this are within .05 of one."""
    near, far = plate(0.0, 0.25), plate(0.1, 0.275)
    single, one_pass, three = (
        above_the_middle(Baking(radius=2, passes=passes), *things)
        for passes, things in ((1, [near]), (1, [near, far]), (3, [near, far]))
    )
    assert one_pass - single > 0.05 > three - single > -0.01


def test_many_small_disks_become_few_and_layers_of_a_cell_are_one() -> None:
    rng = np.random.default_rng(0)
    flat = rng.random((5000, 3)) * [1, 1, 1e-3]
    disks = np.column_stack([flat, np.tile([0, 0, 1], (5000, 1)), np.full(5000, 1 / 5000)])
    few = _joined(disks, 0.25)
    assert len(few) == 16 and few[:, 6].sum() == pytest.approx(1, abs=0.05)
    assert _joined(np.concatenate([disks, disks]), 0.25)[:, 6].sum() == pytest.approx(1, abs=0.05)


def test_pieces_keep_the_area_and_are_small() -> None:
    rays = RayScene(default_scene())
    whole = sum(
        np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1).sum() / 2
        for part in range(sum(len(mesh.transforms) for mesh in rays.scene.meshes))
        for c in [rays.triangles.corners(part, np.arange(len(rays.triangles.placed(part)[0].triangles), dtype=np.int32))[0]]
    )
    fine = disks_of(rays, 0.1)
    assert fine[:, 6].sum() == pytest.approx(whole, rel=0.15)  # round things hide layers of their own cells
    assert fine[:, 6].max() <= 3 * math.sqrt(3) / 4 * 0.1**2


def test_baked_by_elements_is_near_to_baked_by_rays() -> None:
    """On floor and walls; what is buried or nearly so comes out too bright."""
    settings = Baking(spp=64, radius=0.7)
    by_rays, by_elements = (ao.bake(default_scene(), replace(settings, by=by)) for by in ("rays", "elements"))
    for rays, disks in zip(by_rays.meshes[:2], by_elements.meshes[:2], strict=True):
        assert rays.name in ("floor", "walls")
        assert np.sqrt(((rays.visibility - disks.visibility) ** 2).mean()) < 0.06
    assert by_elements.rays == 0 and by_elements.seconds > 0


def test_the_same_bytes_twice_and_textures_too() -> None:
    made = [
        ao.bake(default_scene(), Baking(by="elements", radius=0.5), to=OcclusionTexture(size=32)).meshes[0].visibility
        for _ in range(2)
    ]
    assert made[0].tobytes() == made[1].tobytes() and 0 < made[0].min() < made[0].max() <= 1


def test_what_elements_do_not_know_is_refused() -> None:
    with pytest.raises(ao.SettingsError, match="falloff 'quadratic': elements know a hard radius only"):
        Baking(by="elements", falloff="quadratic")
    with pytest.raises(ao.SceneError, match=r"more than 8,000,000 elements .* larger radius"):
        ao.bake(default_scene(), Baking(by="elements", radius=1e-3))
