"""Spheres in the G-buffer: where rays meet them, under every lens, near and far, cut by the near plane and from within."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import trimesh

import ssao_gl as ao
from ssao_gl.gl import sphere_buffers
from ssao_gl.gl.drawn_depth import DrawnDepth
from ssao_gl.gl.executor import FrameExecutor, SceneView
from ssao_gl.gl.programs import GpuResources
from ssao_gl.gl.scene_buffers import SceneBuffers
from ssao_gl.graph.frame_graph import compile
from ssao_gl.graph.names import DEPTH_LAYER_2
from ssao_gl.passes.gbuffer import gbuffer, layer_behind
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lens import CropLens
from ssao_gl.scene.model import Scene
from ssao_gl.scene.spheres import Spheres

from ..shapes import look_at, quad

SIZE = (128, 96)
RANDOM = np.random.default_rng(5)
CENTERS, RADII = RANDOM.uniform(-1, 1, (24, 3)).astype(np.float32), RANDOM.uniform(0.1, 0.4, 24).astype(np.float32)
POSE = look_at((3, 2, 4), (0.1, 0, 0))
OBLIQUE = np.array([[1.5, 0, 0.3, 0], [0, 2.0, -0.2, 0], [0, 0, -1.01, -0.2], [0, 0, -1, 0]])
SHEARED = np.array([[0.5, 0, 0.1, 0], [0, 0.6, -0.05, 0], [0, 0, -0.1, 0.0], [0, 0, 0, 1.0]])
CAMERAS = {
    "perspective": Camera.perspective(0.7, 0.1, 40, POSE),
    "wide": Camera.perspective(2.4, 0.1, 40, look_at((0.9, 0.8, 1.6), (0, 0, 0))),
    "parallel": Camera.orthographic(3, 0.1, 40, POSE),
    "off centre": Camera.from_matrix(OBLIQUE, POSE),
    "oblique parallel": Camera.from_matrix(SHEARED, POSE),
    "near plane through": Camera.perspective(0.7, 5.0, 40, POSE),
    "endless": Camera.perspective(0.7, 0.1, None, POSE),
    "within": Camera.perspective(1.2, 0.01, 40, look_at(tuple(map(float, CENTERS[0])), (0, 0, 0))),
    "far plane through": Camera.perspective(0.7, 0.1, 5.2, POSE),
    "log depth": Camera.perspective(0.7, 1e-4, 1e4, POSE),
}


def expected(
    spheres: list[tuple[np.ndarray, float]], camera: Camera, size: tuple[int, int] = SIZE
) -> tuple[np.ndarray, np.ndarray]:
    """Depth (h, w), 0 = background, and normals (h, w, 3) in view space, by rays in 64-bit."""
    view = camera.view(size)
    start, one = view.points(np.zeros(size[::-1])), view.points(np.ones(size[::-1]))
    ray = one - start
    depth, normal = np.full(size[::-1], np.inf), np.zeros((*size[::-1], 3))
    to_view = np.linalg.inv(camera.pose)
    for center, radius in spheres:
        c = start - (to_view[:3, :3] @ center + to_view[:3, 3])
        a, b = (ray**2).sum(-1), (c * ray).sum(-1)
        d = b * b - a * ((c**2).sum(-1) - radius**2)
        for sign in (-1, 1):
            with np.errstate(invalid="ignore"):
                t = (-b + sign * np.sqrt(d)) / a
                hit = (d >= 0) & (t >= view.near) & (t <= view.far) & (t < depth)
            depth[hit] = t[hit]
            normal[hit] = -sign * ((c + t[..., None] * ray) / radius)[hit]
    return np.where(np.isfinite(depth), depth, 0), normal


def check(renderer: ao.Renderer, spheres: Spheres, camera: Camera, scale: float = 1.0) -> None:
    places = [
        (m[:3, :3] @ c + m[:3, 3], r)
        for m in spheres.transforms
        for c, r in zip(spheres.centers.astype(float), spheres.radii, strict=True)
    ]
    depth, normal = expected(places, camera)
    picture = renderer.render(Scene(spheres=[spheres]), camera, SIZE, aovs=("depth", "normal"), checked=True)
    both = (picture.depth > 0) & (depth > 0)
    assert (depth > 0).sum() > 50
    # Outlines may round to either side; at them, a hair aside is far behind.
    assert ((picture.depth > 0) != (depth > 0)).mean() < 2e-3
    error = np.abs(picture.depth - depth)[both] / scale
    assert np.quantile(error, 0.99) < 2e-5 * max(1, float(np.median(depth[both])) / scale)
    assert np.quantile(np.abs(picture.normal - normal)[both], 0.99) < 2e-3
    assert (error > 1e-3).mean() < 5e-3


@pytest.mark.parametrize("name", CAMERAS)
def test_depth_and_normals_are_those_of_rays(name: str, renderer: ao.Renderer) -> None:
    check(renderer, Spheres(CENTERS, RADII), CAMERAS[name])


@pytest.mark.parametrize("scale", [1e-12, 1e-3, 1e6, 1e15])
def test_units_do_not_matter(scale: float, renderer: ao.Renderer) -> None:
    pose = POSE.copy()
    pose[:3, 3] *= scale
    check(
        renderer,
        Spheres(CENTERS * np.float32(scale), RADII * np.float32(scale)),
        Camera.perspective(0.7, 0.1 * scale, 40 * scale, pose),
        scale,
    )


def test_a_sphere_far_away_is_as_round_as_a_near_one(renderer: ao.Renderer) -> None:
    """A million radii away through a long lens: nothing cancels out."""
    scene = Scene(spheres=[Spheres(np.zeros((1, 3)), np.ones(1))])
    camera = Camera.perspective(3e-6, 9e5, 1.1e6, look_at((0, 0, 1e6), (0, 0, 0)))
    picture = renderer.render(scene, camera, SIZE, aovs=("normal", "depth"), checked=True)
    _, normal = expected([(np.zeros(3), 1.0)], camera)
    both = (picture.depth > 0) & (normal[..., 2] > 0.1)
    assert both.mean() > 0.2 and np.abs(picture.normal - normal)[both].max() < 5e-3


def test_copies_are_drawn_as_if_written_out(renderer: ao.Renderer) -> None:
    turns = np.stack([trimesh.transformations.rotation_matrix(angle, [0, 1, 0]) for angle in (0, 0.9, 2.0)])
    turns[:, :3, 3] = [[0, 0, 0], [1, 0.5, 0], [-1, 0.2, 0]]
    check(renderer, Spheres(CENTERS, RADII, transforms=turns), CAMERAS["perspective"])


def test_order_and_colors(renderer: ao.Renderer) -> None:
    colors = np.array([[255, 0, 0, 255], [0, 255, 0, 255]], np.uint8)
    near, far = [0, 0, 1], [0, 0, -1]
    camera = Camera.perspective(0.7, 0.1, 40, look_at((0, 0, 6), (0, 0, 0)))
    for centers in ([near, far], [far, near]):
        scene = Scene(spheres=[Spheres(np.array(centers), np.array([0.5, 0.5]), colors)])
        picture = renderer.render(scene, camera, SIZE, aovs=("color", "depth"))
        assert picture.color[48, 64].argmax() == centers.index(near)
        assert picture.depth[48, 64] == pytest.approx(4.5, rel=1e-3)


def test_meshes_and_spheres_hide_each_other(renderer: ao.Renderer) -> None:
    scene = Scene(
        [quad((0, 0, 0), (3, 0, 0), (0, 3, 0))], spheres=[Spheres(np.array([[0, 0, 0], [0, 1, -2]]), np.array([1, 0.5]))]
    )
    camera = Camera.perspective(0.7, 0.1, 40, look_at((0, 0, 6), (0, 0, 0)))
    depth = renderer.render(scene, camera, SIZE, aovs="depth").depth
    ball, _ = expected([(np.zeros(3), 1.0)], camera)
    np.testing.assert_allclose(depth, np.where(ball > 0, np.minimum(ball, 6), 6), rtol=1e-3)


def test_the_surface_behind_is_the_back_of_the_sphere(provider: str) -> None:
    """Before what lies behind the sphere."""
    scene = Scene(spheres=[Spheres(np.array([[0, 0, 0], [0, 0, -3]]), np.array([1, 1]))])
    camera = Camera.perspective(0.7, 0.1, 40, look_at((0, 0, 6), (0, 0, 0)))
    plan = compile([gbuffer((1.0, 1, 1), geometric=True), layer_behind(0.0, 1)], SIZE, [DEPTH_LAYER_2])
    with ao.gl.open(provider) as ctx:
        resources = GpuResources(ctx)
        buffers, executor = SceneBuffers(resources, scene), FrameExecutor(resources, plan)
        behind = executor.run(camera.view(SIZE), scene=SceneView(buffers, camera), checked=True).read(DEPTH_LAYER_2)[::-1, :, 0]
        for made in (executor, buffers, resources):
            made.release()
    assert behind[48, 64] == pytest.approx(7, rel=1e-3) and behind[0, 0] == 0


def test_a_part_of_an_image_is_that_part(renderer: ao.Renderer) -> None:
    camera = CAMERAS["perspective"]
    whole = renderer.render(Scene(spheres=[Spheres(CENTERS, RADII)]), camera, SIZE, aovs="depth").depth
    part = dataclasses.replace(camera, lens=CropLens(camera.lens, SIZE, (32, 24)))
    seen = renderer.render(Scene(spheres=[Spheres(CENTERS, RADII)]), part, (64, 48), aovs="depth").depth
    np.testing.assert_allclose(seen, whole[24:72, 32:96], rtol=1e-5, atol=1e-5)


def test_spheres_without_a_size_are_not_seen(renderer: ao.Renderer) -> None:
    centers = np.array([[0, 0, 0], [0.5, 0, 0], [0.5, 0, 0]])
    with_points = Scene(spheres=[Spheres(centers, np.array([1, 0, 0.7]))])
    without = Scene(spheres=[Spheres(centers[[0, 2]], np.array([1, 0.7]))])
    camera = CAMERAS["perspective"]
    a, b = (renderer.render(scene, camera, SIZE, aovs="depth").depth for scene in (with_points, without))
    np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    "name", ["perspective", "wide", "parallel", "off centre", "oblique parallel", "near plane through", "within"]
)
def test_what_others_hide_is_left_out_and_changes_no_byte(
    name: str, renderer: ao.Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    random = np.random.default_rng(8)
    spheres = Spheres(
        random.uniform(-1, 1, (6000, 3)).astype(np.float32),
        random.uniform(0.02, 0.08, 6000).astype(np.float32),
        random.integers(0, 255, (6000, 4), np.uint8) | np.uint8([0, 0, 0, 255]),
    )
    scene, aovs = Scene(spheres=[spheres]), ("depth", "normal", "color")
    taken = []
    update = DrawnDepth.update
    monkeypatch.setattr(DrawnDepth, "update", lambda self, depth: (taken.append((depth > 0).mean()), update(self, depth))[1])
    whole = renderer.render(scene, CAMERAS[name], SIZE, aovs=aovs)
    assert not taken
    monkeypatch.setattr(sphere_buffers, "MANY", 1)
    waves = renderer.render(scene, CAMERAS[name], SIZE, aovs=aovs, checked=True)
    assert len(taken) >= 2 and taken == sorted(taken) and taken[0] > 0.005
    for aov in aovs:
        assert whole.arrays[aov].tobytes() == waves.arrays[aov].tobytes(), aov


def test_spheres_behind_what_is_drawn_are_not_drawn(renderer: ao.Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a depth that hides everything only the first wave is there; with one that hides nothing, all."""
    monkeypatch.setattr(sphere_buffers, "MANY", 1)
    centers = np.random.default_rng(2).uniform(-1, 1, (6000, 3)).astype(np.float32)
    scene = Scene(spheres=[Spheres(centers, np.full(6000, 0.03, np.float32))])
    update, covered = DrawnDepth.update, {}
    for name, depth in (("near", 1e-3), ("far", 1e3), ("none", 0.0)):
        first: list[int] = []

        def updated(self: DrawnDepth, drawn: np.ndarray, depth: float = depth, first: list[int] = first) -> None:
            first.append(int((drawn > 0).sum()))
            update(self, np.full_like(drawn, depth))

        monkeypatch.setattr(DrawnDepth, "update", updated)
        picture = renderer.render(scene, CAMERAS["perspective"], SIZE, aovs=("depth",), checked=True)
        covered[name] = int((picture.depth > 0).sum()), first[0]
    assert covered["near"][0] == covered["near"][1] < 0.5 * covered["far"][0]
    assert covered["far"] == covered["none"]
