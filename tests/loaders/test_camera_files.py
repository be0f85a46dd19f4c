"""Camera files: what they may say, and which camera of them is taken."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssao_gl.errors import InputWarning, SceneError
from ssao_gl.loaders.camera_files import load_camera, load_cameras
from ssao_gl.scene.lens import Orthographic, Perspective
from ssao_gl.scene.pose import look_at

FRONT: dict[str, Any] = {"name": "front", "eye": [0, 0, 5], "target": [0, 0, 0], "yfov_deg": 40}
PLAN: dict[str, Any] = {"name": "plan", "eye": [0, 9, 0], "target": [0, 0, 0], "up": [0, 0, -1], "ortho_height": 4}


def write(folder: Path, *cameras: dict[str, Any], **more: Any) -> Path:
    path = folder / "scene.cam.json"
    path.write_text(json.dumps({"cameras": cameras, **more}))
    return path


def test_perspective(tmp_path: Path) -> None:
    entry = FRONT | {"up": [0, 1, 0], "znear": 0.5, "zfar": 50, "ao_radius": 0.25, "note": "further keys may be there"}
    (camera,) = load_cameras(write(tmp_path, entry, scene="a.glb"))
    assert camera.lens == Perspective(math.radians(40), 0.5, 50)
    assert camera.name == "front" and camera.ao_radius == 0.25
    np.testing.assert_allclose(camera.pose, look_at([0, 0, 5], [0, 0, 0]))


def test_what_may_be_left_out(tmp_path: Path) -> None:
    entry = {key: value for key, value in FRONT.items() if key != "name"}
    (camera,) = load_cameras(write(tmp_path, entry | {"zfar": None, "ao_radius": None}))
    assert camera.lens == Perspective(math.radians(40), 0.01, None)
    assert camera.name == "0" and camera.ao_radius is None


def test_parallel_projection(tmp_path: Path) -> None:
    (camera,) = load_cameras(write(tmp_path, PLAN | {"znear": 0, "zfar": 20}))
    assert camera.lens == Orthographic(4, 0, 20)
    np.testing.assert_allclose(camera.pose[:3, 2], [0, 1, 0], atol=1e-12)


def test_choice(tmp_path: Path) -> None:
    path = write(tmp_path, FRONT, PLAN, FRONT | {"name": "1"})
    with pytest.warns(InputWarning, match="1 of 3 cameras: the first one, 'front', is taken; choose by FILE:NAME"):
        assert load_camera(str(path)).name == "front"
    assert load_camera(f"{path}:plan").name == "plan"
    assert load_camera(f"{path}:0").name == "front"
    assert load_camera(f"{path}:1").name == "1", "a name is stronger than a number"
    assert load_camera(f"{path}:2").name == "1"
    with pytest.raises(SceneError, match=r"no camera 'plans'; it has front, plan, 1 .*Did you mean 'plan'\?"):
        load_camera(f"{path}:plans")


def test_colon_in_the_name_of_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, FRONT).rename(tmp_path / "a:b.cam.json")
    assert load_camera(str(path)).name == load_camera(f"{path}:front").name == "front"


def test_errors_name_file_camera_and_key(tmp_path: Path) -> None:
    path = write(tmp_path, FRONT, PLAN | {"ortho_height": -1})
    with pytest.raises(SceneError) as raised:
        load_cameras(path)
    assert str(raised.value) == f"{path}: camera 1 ('plan'): an orthographic height of -1; it must be above 0"


def test_not_a_camera_file(tmp_path: Path) -> None:
    path = tmp_path / "a.cam.json"
    path.write_bytes(b" " * (17 << 20))
    with pytest.raises(SceneError, match="larger than 16 MiB"):
        load_cameras(path)
    path.write_bytes(b"\xff\xfe{}")
    with pytest.raises(SceneError, match="not JSON"):
        load_cameras(path)
