"""Occlusion by disks, against closed forms and against rays."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.bake.disk_tree import disk_tree
from ssao_gl.bake.disks import disks_of
from ssao_gl.bake.elements import Elements, elements
from ssao_gl.bake.settings import Baking, OcclusionTexture
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.sample_scene import default_scene
from ssao_gl.scene.surface_patches import joined
from ssao_gl.truth.rays import RayScene

pytest.importorskip("numba")
pytest.importorskip("embreex")

UP = np.array([[0.0, 0.0, 1.0]])
HERE = np.zeros((1, 3))


def one_disk(height: float, radius: float, *, gems: bool = False, reach: float = 2.0) -> Elements:
    """Made by hand."""
    tree = disk_tree(np.array([[0, 0, height, 0, 0, -1, math.pi * radius**2]]))
    return Elements(tree, np.ones((1, 2, 1)), 1, reach, gems)


def taken(made: Elements, point: np.ndarray = HERE) -> np.ndarray:
    """Of the hemispheres above and below a point."""
    return made.gather(point, UP)[0, :, 0]


def plate(height: float, half: float = 0.5) -> Mesh:
    corners = np.array([[-half, -half, height], [half, -half, height], [half, half, height], [-half, half, height]], np.float32)
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))


def two_plates() -> Scene:
    """A red plate above a grey one."""
    return Scene([plate(-0.3), replace(plate(0.0), color=(1.0, 0.2, 0.2))])


def above_the_middle(settings: Baking, *things: Mesh) -> float:
    """What meshes take of the hemisphere of the middle of the ground, which lies ``1`` below their origin."""
    rays = RayScene(Scene([*things, plate(-9, 1e-3)]))  # a mote, so that the place of the ground is within the grid
    point = ((HERE + [0, 0, -1]) - rays.center) * rays.scale
    return 1 - float(elements(rays, settings).light(point, UP)[0, 0])


@pytest.mark.parametrize("radius", [0.01, 0.3, 1.0, 3.0])
def test_a_disk_is_exact_on_its_axis(radius: float) -> None:
    """a^2 / (a^2 + h^2), the form factor of a disk."""
    found = taken(one_disk(0.5, radius))
    assert found[0] == pytest.approx(radius**2 / (radius**2 + 0.25), rel=1e-12) and found[1] == 0


@pytest.mark.parametrize("radius", [0.01, 0.3, 1.0, 3.0])
def test_the_kernel_of_the_book_is_the_solid_angle(radius: float) -> None:
    """1 - 1 / sqrt(1 + a^2 / h^2): .293 where the form factor is .5. This deviation is the book's."""
    found = taken(one_disk(0.5, radius, gems=True))[0]
    assert found == pytest.approx(1 - 1 / math.sqrt(1 + radius**2 / 0.25), rel=1e-12)


def test_what_lies_beyond_the_radius_takes_nothing_and_what_lies_behind_is_behind() -> None:
    assert taken(one_disk(0.5, 0.3, reach=0.5)).max() == 0
    behind = taken(one_disk(-0.5, 0.3))
    assert behind[0] == 0 and behind[1] > 0


def test_a_plate_is_exact_however_it_is_cut() -> None:
    """A square above a point, as disks of its pieces: four times the form factor of a rectangle seen from below its corner."""
    half, height = 0.5, 1.0
    x = half / height
    corner = 2 * x / math.sqrt(1 + x * x) * math.atan(x / math.sqrt(1 + x * x)) / (2 * math.pi)
    for radius in (1.5, 4.0):
        found = above_the_middle(Baking(radius=radius, passes=1), plate(0.0))
        assert found == pytest.approx(4 * corner, abs=0.01)


@pytest.mark.parametrize(("half", "radius", "within"), [(0.25, 2.0, 0.05), (0.5, 2.0, 0.1)])
def test_two_plates_darken_nearly_as_one_does(half: float, radius: float, within: float) -> None:
    """The second is hidden by the first. One pass counts both; four count little more than one."""
    near, far = plate(0.0, half), plate(0.1, half * 1.1)
    single, one_pass, four = (
        above_the_middle(Baking(radius=radius, passes=passes), *things)
        for passes, things in ((1, [near]), (1, [near, far]), (4, [near, far]))
    )
    assert one_pass > 1.8 * single and -0.01 < four - single < within


def test_far_branches_take_what_their_leaves_take() -> None:
    """With an endless radius, against the sum over all disks: within .01."""
    rays = RayScene(default_scene())
    made = elements(rays, Baking(radius=1e3, passes=1))
    tree, leaves = made.tree, made.tree.disks
    assert len(leaves) < len(tree.nodes) < 2 * len(leaves)
    flat = replace(
        tree,
        nodes=np.column_stack([leaves, np.ones(len(leaves))]),
        extent=tree.extent[: len(leaves)],
        skip=np.arange(1, len(leaves) + 1),
    )
    every = replace(made, tree=flat, weights=np.ones((len(leaves), 2, 1)))
    points = leaves[::97]
    by_tree, by_all = (np.minimum(one.gather(points[:, :3], points[:, 3:6])[:, :, 0], 1) for one in (made, every))
    assert by_all.max() > 0.3 and np.sqrt(((by_tree - by_all) ** 2).mean()) < 0.01


def test_a_tree_holds_every_disk_once_and_branches_their_sums() -> None:
    disks = disks_of(RayScene(default_scene()), 0.1)
    tree = disk_tree(disks)
    leaf = tree.last - tree.first == 1
    assert (tree.first[leaf] == np.arange(len(disks))).all() and (np.sort(disks[:, 6]) == np.sort(tree.disks[:, 6])).all()
    assert (tree.skip[leaf] == np.flatnonzero(leaf) + 1).all() and (tree.skip > np.arange(len(tree.skip))).all()
    widest = int(np.argmax(tree.last - tree.first))
    inside = tree.disks[tree.first[widest] : tree.last[widest]]
    assert tree.nodes[widest, 6:].prod() == pytest.approx(inside[:, 6].sum()) and len(inside) > 100
    assert tree.nodes[widest, :3] == pytest.approx((inside[:, :3] * inside[:, 6:]).sum(0) / inside[:, 6].sum())
    assert tree.means(tree.disks[:, 0])[widest] == pytest.approx(tree.nodes[widest, 0])


def test_a_plate_sends_its_colour_by_the_same_kernel() -> None:
    """Under a sky of 1 its lower side is lit in full: what it takes of the hemisphere it sends back, times its colour."""
    red = replace(plate(0.0), color=(1.0, 0.5, 0.0))
    rays = RayScene(Scene([red, plate(-9, 1e-3)]))
    made = elements(rays, Baking(by="elements", radius=4, passes=2, indirect=True))
    visibility, *light = made.light(((HERE + [0, 0, -1]) - rays.center) * rays.scale, UP)[0]
    assert light == pytest.approx((1 - visibility) * np.array([1, 0.2140411, 0]), rel=1e-3) and visibility < 0.8


def test_indirect_light_goes_into_colours(tmp_path: Path) -> None:
    baked = ao.bake(two_plates(), Baking(by="elements", radius=1.2, passes=2, indirect=True))
    plain = ao.bake(two_plates(), Baking(by="elements", radius=1.2, passes=2))
    assert plain.meshes[0].indirect is None and baked.meshes[0].indirect is not None
    assert np.array_equal(plain.meshes[0].visibility, baked.meshes[0].visibility)
    assert baked.meshes[0].indirect.shape == (len(baked.meshes[0].visibility), 3)
    assert baked.meshes[0].indirect.min() >= 0 and 0.05 < baked.meshes[0].indirect.max() < 1
    means = []
    for one in (plain, baked):
        one.save(tmp_path / "a.glb")
        means.append(np.mean([mesh.vertex_colors[:, :3].mean() for mesh in ao.load_scene(tmp_path / "a.glb").meshes]))
    assert means[1] > means[0] + 1
    assert len(baked.save(tmp_path / "arrays")) == 2 * len(baked.meshes)


def test_many_small_disks_become_few_and_layers_of_a_cell_are_one() -> None:
    rng = np.random.default_rng(0)
    flat = rng.random((5000, 3)) * [1, 1, 1e-3]
    disks = np.column_stack([flat, np.tile([0, 0, 1], (5000, 1)), np.full(5000, 1 / 5000)])
    few = joined(disks, 0.25)
    assert len(few) == 16 and few[:, 6].sum() == pytest.approx(1, abs=0.05)
    assert joined(np.concatenate([disks, disks]), 0.25)[:, 6].sum() == pytest.approx(1, abs=0.05)


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
        ao.bake(two_plates(), Baking(by="elements", radius=1.2), to=OcclusionTexture(size=32)).meshes[0].visibility
        for _ in range(2)
    ]
    assert made[0].tobytes() == made[1].tobytes() and 0 <= made[0].min() < 0.5 < made[0].max() <= 1


def test_what_elements_do_not_know_is_refused() -> None:
    with pytest.raises(ao.SettingsError, match="falloff 'quadratic': elements know a hard radius only"):
        Baking(by="elements", falloff="quadratic")
    with pytest.raises(ao.SettingsError, match="indirect: is the light that elements send"):
        Baking(indirect=True)
    with pytest.raises(ao.SettingsError, match="indirect: is light in colours, which COLOR_0 of vertices keeps"):
        ao.bake(default_scene(), Baking(by="elements", indirect=True), to="texture")
    with pytest.raises(ao.SceneError, match=r"more than 8,000,000 elements .* larger radius"):
        ao.bake(default_scene(), Baking(by="elements", radius=1e-3))
