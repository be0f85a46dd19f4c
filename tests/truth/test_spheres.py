"""Rays through spheres against closed forms, against all pairs of rays and spheres, and against Embree."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import trimesh

import ssao_gl as ao
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.spheres import Spheres
from ssao_gl.truth import Tracing, gather, surface
from ssao_gl.truth.closed_forms import closed_forms
from ssao_gl.truth.spheres import SphereBlockers
from ssao_gl.truth.store import content_key

from ..shapes import look_at, quad

RANDOM = np.random.default_rng(2)
TO_LOCAL = np.eye(4)[:3]


def packed(count: int, spread: float = 0.8) -> Spheres:
    return Spheres(RANDOM.uniform(-spread, spread, (count, 3)), RANDOM.uniform(0.02, 0.15, count))


def all_pairs(spheres: Spheres, origins: np.ndarray, directions: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Distance and sphere (-1: none) of the first hit of each ray."""
    c = origins.astype(float)[:, None] - spheres.centers.astype(float)
    d = directions.astype(float)
    a, b = (d * d).sum(1)[:, None], np.einsum("rsk,rk->rs", c, d)
    inside = b * b - a * ((c * c).sum(-1) - spheres.radii.astype(float) ** 2)
    root = np.sqrt(np.maximum(inside, 0))
    near, far = (-b - root) / a, (-b + root) / a
    t = np.where(near > 0, near, far)
    t = np.where((inside >= 0) & (t > 0) & (t < reach), t, np.inf)
    which = t.argmin(1)
    return t.min(1), np.where(np.isfinite(t.min(1)), which, -1)


@pytest.mark.parametrize("kind", ["packed", "one", "coincident", "sizes", "sparse"])
def test_the_walk_finds_what_all_pairs_do(kind: str) -> None:
    spheres = {
        "packed": packed(400),
        "one": Spheres(np.zeros((1, 3)), np.array([0.5])),
        "coincident": Spheres(np.zeros((50, 3)), np.full(50, 0.3)),
        "sizes": Spheres(RANDOM.uniform(-0.5, 0.5, (200, 3)), 10.0 ** RANDOM.uniform(-4, -0.5, 200)),
        "sparse": Spheres(np.array([[-0.99, 0, 0], [0.99, 0, 0]]), np.array([1e-3, 1e-3])),
    }[kind]
    blockers = SphereBlockers([(spheres, TO_LOCAL)])
    origins = RANDOM.uniform(-1.2, 1.2, (3000, 3)).astype(np.float32)
    target = spheres.centers[RANDOM.integers(0, len(spheres.centers), 3000)]
    target = target + RANDOM.normal(0, 1, (3000, 3)) * spheres.radii[0]
    directions = (target - origins).astype(np.float32)
    directions[:30] = np.eye(3)[np.arange(30) % 3]  # along the axes
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    for reach in (0.3, 4.0):
        distance, which = all_pairs(spheres, origins, unit, reach)
        np.testing.assert_array_equal(blockers.occluded(origins, unit, reach), which >= 0)
        np.testing.assert_allclose(blockers.distances(origins, unit, reach), np.minimum(distance, reach), rtol=1e-6)
        hits = blockers.hits(origins, unit, np.full(3000, reach, np.float32))
        np.testing.assert_array_equal(hits.rays, np.flatnonzero(which >= 0))
        of = spheres.centers[which[hits.rays]].astype(float)
        np.testing.assert_allclose(np.linalg.norm(hits.points - of, axis=1), spheres.radii[which[hits.rays]], rtol=1e-6)
    assert (which >= 0).sum() > 50


@pytest.mark.parametrize("name", ["ball", "raised_ball"])
def test_a_ball_on_a_plane(name: str) -> None:
    """The mesh of the closed form replaced by the sphere that it stands for."""
    form = closed_forms()[name]
    floor, ball = form.scene.meshes
    spheres = Spheres(np.zeros((1, 3)), np.ones(1), transforms=ball.transforms)
    seen = surface(Scene([floor], spheres=[spheres]), form.camera, (12, 9))
    exact = form.visibility(seen.points())
    known = np.isfinite(exact)
    found = gather(seen, Tracing(radius=form.radius, spp=16384))
    error = (found.visibility[found.covered] - exact)[known]
    assert known.sum() >= 24 and np.abs(error).max() < 0.003 and abs(error.mean()) < 0.0005


def clipped_by_horizon(distance: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Occlusion by a unit sphere that the horizon cuts (Lagarde & de Rousiers, Moving Frostbite to PBR, 2014)."""
    above = distance**2 - 1
    k = 1 - distance**2 * cosine**2
    angle = np.arccos(-cosine * np.sqrt(above / (1 - cosine**2)))
    return ((cosine * angle - np.sqrt(k * above)) / distance**2 + np.arctan(np.sqrt(k / above))) / np.pi


def test_two_spheres_that_touch() -> None:
    spheres = Spheres(np.array([[-1, 0, 0], [1, 0, 0]]), np.ones(2))
    camera = Camera.orthographic(2.2, 0.1, 20, look_at((0, 0, 5), (0, 0, 0)))
    seen = surface(Scene(spheres=[spheres]), camera, (44, 22))
    found = gather(seen, Tracing(radius=20, spp=4096)).visibility[seen.covered]
    points = seen.points()
    side = np.sign(points[:, :1])
    n, to = points - side * [1, 0, 0], -side * [1, 0, 0] - points
    distance = np.linalg.norm(to, axis=1)
    cosine = (n * to).sum(1) / distance
    cut = np.abs(cosine) < 1 / distance
    exact = np.where(cut, 1 - clipped_by_horizon(np.where(cut, distance, 2), np.where(cut, cosine, 0)), 1)
    assert cut.sum() > 50 and exact.min() < 0.4 and np.abs(found - exact).max() < 0.01


def icospheres(spheres: Spheres, subdivisions: int) -> Scene:
    """As triangles of the same area in the mean."""
    ball = trimesh.creation.icosphere(subdivisions)
    grown = ball.vertices * np.sqrt(4 * np.pi / ball.area)
    transforms = np.repeat(np.eye(4)[None], len(spheres.centers), 0)
    transforms[:, :3, :3] *= spheres.radii[:, None, None]
    transforms[:, :3, 3] = spheres.centers
    return Scene([Mesh(grown.astype(np.float32), ball.faces.astype(np.uint32), transforms=transforms)])


def test_embree_agrees_on_icospheres() -> None:
    spheres = packed(80)
    camera = Camera.perspective(0.7, 0.1, 20, look_at((2, 1, 2.5), (0, 0, 0)))
    a, b = (
        gather(surface(scene, camera, (64, 48)), Tracing(radius=0.4, spp=256))
        for scene in (Scene(spheres=[spheres]), icospheres(spheres, 4))
    )
    both = a.covered & b.covered
    assert both.mean() > 0.1 and (a.covered != b.covered).mean() < 0.01
    assert abs(float((a.visibility - b.visibility)[both].mean())) < 0.002


def test_a_camera_within_a_sphere_sees_it_closed() -> None:
    scene = Scene([quad((0, 0, -4), (1, 0, 0), (0, 1, 0))], spheres=[Spheres(np.zeros((1, 3)), np.ones(1))])
    found = gather(surface(scene, Camera.perspective(0.7, 0.01, 20), (8, 6)), Tracing(radius=5, spp=32))
    assert found.covered.all() and (found.visibility == 0).all()
    np.testing.assert_allclose(found.depth[3, 4], 1, atol=0.02)


def test_the_key_goes_by_what_is_drawn() -> None:
    camera, tracing = Camera.perspective(0.7, 0.1, 20), Tracing(radius=1)
    base = packed(5)
    same = Spheres(base.centers.copy(), base.radii.copy(), np.full((5, 4), 9, np.uint8), name="another")
    others = [
        Spheres(base.centers, base.radii * np.float32(1.001)),
        Spheres(base.centers + np.float32(1e-3), base.radii),
        Spheres(base.centers, base.radii, transforms=np.diag([-1, 1, 1, 1.0])[None]),
    ]
    first, again, *rest = (content_key(Scene(spheres=[one]), camera, (8, 6), tracing) for one in (base, same, *others))
    assert first == again and len({first, *rest}) == 4


def test_what_is_missing_or_too_much_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene(spheres=[packed(1000)])
    monkeypatch.setattr(sys.modules["ssao_gl.truth.blockers"], "machine_memory", lambda: 1e4)
    with pytest.raises(ao.SceneError, match=r"1,000 spheres .* GiB"):
        surface(scene, scene.default_camera(), (8, 6))
    monkeypatch.undo()
    monkeypatch.delattr(sys.modules["ssao_gl.truth"], "sphere_kernels")
    monkeypatch.setitem(sys.modules, "ssao_gl.truth.sphere_kernels", None)
    with pytest.raises(ao.SettingsError, match=r"pip install 'ssao_gl\[truth-spheres\]'"):
        surface(scene, scene.default_camera(), (8, 6))
