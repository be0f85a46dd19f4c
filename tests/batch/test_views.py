"""Cameras of a batch: what generators promise, and what keeps away from surfaces."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.batch.clearance import is_clear, triangle_distances
from ssao_gl.batch.paths import along
from ssao_gl.batch.views import Around, views_of
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.pose import look_at

from .models import pyramid

SIZE = (32, 24)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> ao.Scene:
    return ao.load_scene(pyramid(tmp_path_factory.mktemp("scene") / "a.obj"))


def cameras(spec: str, scene: ao.Scene, **around: float) -> list[Camera]:
    return [view.camera(scene, SIZE) for view in views_of(spec, SIZE, Around(**around), Path("-"))]  # type: ignore[arg-type]


def eyes(found: list[Camera], scene: ao.Scene) -> np.ndarray:
    return np.array([camera.pose[:3, 3] for camera in found]) - scene.core.mean(0)


def test_an_orbit_turns_evenly_about_up(scene: ao.Scene) -> None:
    at = eyes(cameras("orbit:8", scene), scene)
    angles = np.unwrap(np.arctan2(at[:, 0], at[:, 2]))
    assert np.allclose(np.diff(angles), angles[1] - angles[0]) and np.isclose(abs(angles[1] - angles[0]), np.pi / 4)
    assert (at[:, 1] > 0).all()


def test_a_sphere_covers_all_directions(scene: ao.Scene) -> None:
    at = eyes(cameras("sphere:200", scene), scene)
    at /= np.linalg.norm(at, axis=1)[:, None]
    nearest = np.sort(at @ at.T, axis=1)[:, -2]
    apart = np.degrees(np.arccos(nearest))
    # 200 caps of equal area have a diameter of 16 degrees.
    assert apart.min() > 10 and apart.max() < 17
    assert np.abs(at.mean(0)).max() < 0.01


def test_a_seed_turns_the_pattern(scene: ao.Scene) -> None:
    assert not np.allclose(cameras("sphere:4", scene)[0].pose, cameras("sphere:4", scene, seed=1)[0].pose)


def test_all_of_the_scene_is_in_view(scene: ao.Scene) -> None:
    corners = np.array([[x, y, z, 1] for x in scene.bounds[:, 0] for y in scene.bounds[:, 1] for z in scene.bounds[:, 2]])
    for camera in cameras("sphere:12", scene):
        clip = corners @ (camera.lens.matrix(SIZE) @ np.linalg.inv(camera.pose)).T
        assert (np.abs(clip[:, :3]) <= clip[:, 3:]).all()


@pytest.mark.parametrize("distance", [0.02, 0.2, 0.4])
def test_eyes_keep_away_from_surfaces(distance: float, scene: ao.Scene) -> None:
    least = 0.05
    for camera in cameras("sphere:40", scene, distance=distance, keep_away=least):
        corners = np.concatenate([mesh.positions[mesh.triangles] for mesh in scene.meshes]).astype(np.float64)
        weights = np.random.default_rng(1).dirichlet([0.5] * 3, 4000)
        samples = np.einsum("kc,ncx->nkx", weights, corners).reshape(-1, 3)
        assert np.linalg.norm(samples - camera.pose[:3, 3], axis=1).min() > least * scene.extent
    near = cameras("sphere:40", scene, distance=distance, keep_away=0)
    assert not all(is_clear(scene, camera.pose[:3, 3], least * scene.extent) for camera in near)


def test_distances_from_triangles_are_exact() -> None:
    triangle = np.array([[[0.0, 0, 0], [2, 0, 0], [0, 2, 0]]])
    for point, expected in [((0.5, 0.5, 3), 3), ((-3, -4, 0), 5), ((2, 2, 0), np.sqrt(2)), ((1, -2, 0), 2), ((0, 0, 0), 0)]:
        assert np.isclose(triangle_distances(triangle, np.array(point, float))[0], expected)
    flat = np.zeros((1, 3, 3))
    assert triangle_distances(flat, np.array([3.0, 4, 0]))[0] == 5


def test_a_path_goes_through_its_keys() -> None:
    keys = [Camera.perspective(0.5 + i / 10, 0.1, 50, look_at((x, 1, 5), (x, 0, 0))) for i, x in enumerate((0, 1, 4))]
    found = along(keys, 5, SIZE)
    assert np.allclose(found[0].pose, keys[0].pose) and np.allclose(found[-1].pose, keys[2].pose)
    assert (np.diff([camera.pose[0, 3] for camera in found]) > 0).all(), "it never goes back"
    with pytest.raises(ao.SceneError, match="at least two"):
        along(keys[:1], 5, SIZE)


def test_files_give_one_or_all(tmp_path: Path) -> None:
    entry = {"eye": [0, 1, 5], "target": [0, 0, 0], "yfov_deg": 40}
    file = tmp_path / "a.cam.json"
    file.write_text(json.dumps({"cameras": [{**entry, "name": "front"}, {**entry, "name": "back"}]}))
    names = {spec: [view.name for view in views_of(spec, SIZE, Around(), file)] for spec in (f"{file}:all", f"{file}:back")}
    assert list(names.values()) == [["front", "back"], ["back"]]
    assert len(views_of(f"path:{file}", SIZE, Around(), file)) == 25
    assert len(views_of(f"path:{file}:7", SIZE, Around(), file)) == 7


@pytest.mark.parametrize(
    "spec", ["orbit:0", "orbit:x", "sphere:", "sphere:-3", "orbitt", "path:nowhere.json", "nowhere.json:all"]
)
def test_what_is_no_camera_is_refused_in_one_line(spec: str) -> None:
    with pytest.raises(ao.SsaoError) as told:
        views_of(spec, SIZE, Around(), Path("a.obj"))
    assert "\n" not in str(told.value)
