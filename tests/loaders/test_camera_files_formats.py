"""Cameras as other programs write them: each file shows the same two views as the camera that it was made from."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.errors import InputWarning, SceneError, SettingsError
from ssao_gl.loaders.as_scene import as_camera
from ssao_gl.loaders.camera_files import load_camera, load_cameras
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.pose import TURN, look_at

SIZE = (640, 480)
K = np.array([[500.0, 0, 310], [0, 510, 250], [0, 0, 1]])
POSES = [look_at((1, 2, 3), (0, 0.5, -1)), look_at((-2, 1, 0.5), (0, 0, 0), (0, 0, 1))]
VIEWS = [Camera.from_intrinsics(K, SIZE, pose=pose) for pose in POSES]


def same(found: list[Camera], names: list[str] | None = None) -> None:
    assert len(found) == 2 and (names is None or [one.name for one in found] == names)
    for one, right in zip(found, VIEWS, strict=True):
        assert np.allclose(one.pose, right.pose, atol=1e-9)
        assert np.allclose(one.lens.matrix(SIZE), right.lens.matrix(SIZE), atol=1e-9)


def quaternion(turn: Any) -> list[float]:
    """w, x, y, z of a rotation, of which w is not small."""
    w = np.sqrt(1 + np.trace(turn)) / 2
    return [w, *(np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / (4 * w))]


def transforms(folder: Path, **more: Any) -> Path:
    lens = {"fl_x": 500, "fl_y": 510, "cx": 310, "cy": 250, "w": 640, "h": 480}
    frames = [{"file_path": f"./train/r_{i}", "transform_matrix": pose.tolist()} for i, pose in enumerate(POSES)]
    path = folder / "transforms.json"
    path.write_text(json.dumps({**lens, "frames": frames, **more}))
    return path


def test_nerf(tmp_path: Path) -> None:
    path = transforms(tmp_path)
    same(load_cameras(path), ["./train/r_0", "./train/r_1"])
    assert load_camera(f"{path}:r_1").name == load_camera(f"{path}:./train/r_1").name == load_camera(f"{path}:1").name
    with pytest.warns(InputWarning, match=r"1 of 2 cameras: the first one, '\./train/r_0', is taken; choose by FILE:NAME"):
        load_camera(str(path))
    with pytest.warns(InputWarning, match="distortion is not modelled"):
        same(load_cameras(transforms(tmp_path, k1=0.1)))
    with pytest.raises(SceneError, match="OPENCV_FISHEYE is no perspective"):
        load_cameras(transforms(tmp_path, camera_model="OPENCV_FISHEYE"))


def test_nerf_of_blender(tmp_path: Path) -> None:
    """Only the horizontal angle is there: the pictures tell the size, or the caller, or it is guessed."""
    path = tmp_path / "transforms.json"
    frames = [{"file_path": "./train/r_0", "transform_matrix": POSES[0].tolist()}]
    path.write_text(json.dumps({"camera_angle_x": 0.8, "frames": frames}))
    (wide,) = load_cameras(path, (800, 400))
    assert wide.intrinsics((800, 400))[0, 0] == pytest.approx(400 / np.tan(0.4)) == wide.intrinsics((800, 400))[1, 1]
    with pytest.warns(InputWarning, match="taken for square"):
        (square,) = load_cameras(path)
    assert square.intrinsics((100, 100))[1, 1] == pytest.approx(50 / np.tan(0.4))
    (tmp_path / "train").mkdir()
    Image.fromarray(np.zeros((300, 400), np.uint8)).save(tmp_path / "train/r_0.png")
    (tall,) = load_cameras(path)
    assert np.allclose(tall.intrinsics((400, 300))[[0, 1], [0, 1]], 200 / np.tan(0.4))


def colmap_text(folder: Path, model: str = "PINHOLE 640 480 500 510 310 250") -> Path:
    (folder / "cameras.txt").write_text(f"# Camera list\n7 {model}\n")
    lines = ["# Image list"]
    for i, view in enumerate(VIEWS):
        m = view.world_to_camera
        numbers = " ".join(map(repr, map(float, [*quaternion(m[:3, :3]), *m[:3, 3]])))
        lines += [f"{i + 1} {numbers} 7 a view {i}.jpg", "" if i else "10.0 20.0 -1 30.5 40.5 12"]
    (folder / "images.txt").write_text("\n".join(lines) + "\n")
    return folder


def colmap_binary(folder: Path, kind: int = 1, params: tuple[float, ...] = (500, 510, 310, 250)) -> Path:
    (folder / "cameras.bin").write_bytes(struct.pack("<QiiQQ", 1, 7, kind, *SIZE) + struct.pack(f"<{len(params)}d", *params))
    content = struct.pack("<Q", len(VIEWS))
    for i, view in enumerate(VIEWS):
        m = view.world_to_camera
        content += struct.pack("<i7di", i + 1, *quaternion(m[:3, :3]), *m[:3, 3], 7) + f"a view {i}.jpg".encode() + b"\0"
        content += struct.pack("<Q", 1 - i) + (1 - i) * struct.pack("<ddq", 1.0, 2.0, -1)
    (folder / "images.bin").write_bytes(content)
    return folder


@pytest.mark.parametrize("write", [colmap_text, colmap_binary])
def test_colmap(write: Any, tmp_path: Path) -> None:
    folder, names = write(tmp_path), ["a view 0.jpg", "a view 1.jpg"]
    same(load_cameras(folder), names)
    for file in folder.iterdir():
        same(load_cameras(file), names)
    assert load_camera(f"{folder}:a view 1.jpg").name == "a view 1.jpg"


def test_colmap_models(tmp_path: Path) -> None:
    with pytest.warns(InputWarning, match=r"distortion \(SIMPLE_RADIAL\) is not modelled"):
        (one, _) = load_cameras(colmap_text(tmp_path, "SIMPLE_RADIAL 640 480 500 310 250 0.1"))
    assert np.allclose(one.intrinsics(SIZE), [[500, 0, 310], [0, 500, 250], [0, 0, 1]])
    same(load_cameras(colmap_text(tmp_path, "OPENCV 640 480 500 510 310 250 0 0 0 0")))
    with pytest.raises(SceneError, match="OPENCV_FISHEYE is no perspective camera; undistort"):
        load_cameras(colmap_text(tmp_path, "OPENCV_FISHEYE 640 480 500 510 310 250 0 0 0 0"))
    with pytest.raises(SceneError, match="cannot read '7 PINHOLE 640'"):
        load_cameras(colmap_text(tmp_path, "PINHOLE 640"))


@pytest.mark.parametrize("keep", range(0, 250, 7))
def test_colmap_cut_short(keep: int, tmp_path: Path) -> None:
    folder = colmap_binary(tmp_path)
    whole = (folder / "images.bin").read_bytes()
    (folder / "images.bin").write_bytes(whole[: min(keep, len(whole) - 1)])
    with pytest.raises(SceneError) as error:
        load_cameras(folder)
    assert "\n" not in str(error.value)


def test_colmap_that_claims_too_much(tmp_path: Path) -> None:
    folder = colmap_binary(tmp_path)
    whole = bytearray((folder / "images.bin").read_bytes())
    whole[:8] = struct.pack("<Q", 1 << 60)
    (folder / "images.bin").write_bytes(whole)
    with pytest.raises(SceneError, match="damaged or cut short"):
        load_cameras(folder)
    (folder / "images.bin").unlink()
    with pytest.raises(SceneError, match=r"images\.bin: no such file"):
        load_cameras(folder)


def test_bop(tmp_path: Path) -> None:
    entries = {}
    for i, view in enumerate(VIEWS):
        m = view.world_to_camera
        entries[str(i)] = {
            "cam_K": K.ravel().tolist(),
            "depth_scale": 0.1,
            "cam_R_w2c": m[:3, :3].ravel().tolist(),
            "cam_t_w2c": m[:3, 3].tolist(),
        }
    (tmp_path / "000001" / "rgb").mkdir(parents=True)
    path = tmp_path / "000001" / "scene_camera.json"
    path.write_text(json.dumps(entries))
    with pytest.warns(InputWarning, match="taken for 620x500, whose middle is the principal point"):
        load_cameras(path)
    same(load_cameras(path, SIZE), ["0", "1"])
    (tmp_path / "camera.json").write_text(json.dumps({"fx": 500, "fy": 510, "cx": 310, "cy": 250, "width": 640, "height": 480}))
    same(load_cameras(path, (10, 10)))
    assert np.allclose(load_camera(str(tmp_path / "camera.json")).intrinsics(SIZE), K)
    (tmp_path / "camera.json").unlink()
    for i in range(2):
        Image.fromarray(np.zeros((480, 640), np.uint8)).save(tmp_path / f"000001/rgb/{i:06d}.png")
    same(load_cameras(path))


def test_open3d_files(tmp_path: Path) -> None:
    lens = {"width": 640, "height": 480, "intrinsic_matrix": K.T.ravel().tolist()}
    (tmp_path / "k.json").write_text(json.dumps(lens))
    assert np.allclose(load_camera(str(tmp_path / "k.json")).intrinsics(SIZE), K)
    view = {
        "class_name": "PinholeCameraParameters",
        "extrinsic": VIEWS[0].world_to_camera.T.ravel().tolist(),
        "intrinsic": lens,
    }
    (tmp_path / "v.json").write_text(json.dumps(view))
    assert np.allclose(load_camera(str(tmp_path / "v.json")).pose, POSES[0])


def test_our_own_with_poses(tmp_path: Path) -> None:
    path = tmp_path / "a.cam.json"
    path.write_text(json.dumps({"cameras": [json.loads(view.to_json()) for view in VIEWS]}))
    same(load_cameras(path), ["0", "1"])
    path.write_text(VIEWS[1].to_json())
    assert np.array_equal(load_camera(str(path)).pose, POSES[1])
    path.write_text(json.dumps({"cameras": [{"pose": np.diag([1, 2, 1, 1]).tolist(), "yfov_deg": 40}]}))
    with pytest.raises(SceneError, match="camera 0: pose must turn and move only"):
        load_camera(str(path))


@pytest.mark.parametrize(
    "text",
    [
        '{"frames": [{"transform_matrix": 3}]}',
        '{"0": {"cam_K": [1]}}',
        '{"intrinsic_matrix": []}',
        '{"fx": 0, "fy": 1, "cx": 1, "cy": 1}',
        '{"frames": [{"transform_matrix": []}, 3], "fl_x": 1}',
        '{"intrinsic": 3}',
    ],
)
def test_broken_files_are_refused_in_one_line(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(SceneError) as error:
        load_cameras(tmp_path / "a.json", (4, 4))
    assert "\n" not in str(error.value) and str(tmp_path) in str(error.value)


class PyVistaCamera(SimpleNamespace):
    """What ``pyvista.Camera`` has."""


def test_objects_of_other_libraries() -> None:
    lens = SimpleNamespace(width=640, height=480, intrinsic_matrix=K)
    assert np.allclose(as_camera(lens).intrinsics(SIZE), K)
    view = SimpleNamespace(intrinsic=lens, extrinsic=VIEWS[0].world_to_camera)
    assert np.allclose(as_camera(view).pose, POSES[0])
    assert np.allclose(as_camera(K, SIZE).intrinsics(SIZE), K)
    assert np.allclose(as_camera((K, POSES[1]), SIZE).pose, POSES[1])
    assert np.allclose(as_camera((VIEWS[0], POSES[1])).pose, POSES[1])
    shown = PyVistaCamera(
        position=(1, 2, 3),
        focal_point=(0, 0.5, -1),
        up=(0, 1, 0),
        view_angle=30.0,
        clipping_range=(0.1, 9),
        parallel_projection=False,
        parallel_scale=2.0,
    )
    assert np.allclose(as_camera(shown).pose, POSES[0])
    assert np.allclose(as_camera(shown).lens.matrix(SIZE), Camera.perspective(np.pi / 6, 0.1, 9).lens.matrix(SIZE))
    shown.parallel_projection = True
    assert np.allclose(as_camera(shown).lens.matrix(SIZE), Camera.orthographic(4, 0.1, 9).lens.matrix(SIZE))


def test_pyrender_cameras_and_nodes() -> None:
    pyrender = pytest.importorskip("pyrender")
    camera = pyrender.PerspectiveCamera(yfov=0.8, znear=0.1, zfar=9.0)
    right = Camera.perspective(0.8, 0.1, 9, POSES[0])
    for source in ((camera, POSES[0]), pyrender.Node(camera=camera, matrix=POSES[0])):
        found = as_camera(source)
        assert np.allclose(found.pose, POSES[0]) and np.allclose(found.lens.matrix(SIZE), right.lens.matrix(SIZE))
    scaled = POSES[0] @ np.diag([2, 2, 2, 1])
    with pytest.raises(SettingsError, match="turn and move only"):
        as_camera((camera, scaled))


def test_what_is_no_camera() -> None:
    with pytest.raises(SettingsError, match="needs an image's size"):
        as_camera(K)
    for source in (3, object(), np.eye(4), (1, 2), (object(), np.eye(4))):
        with pytest.raises(SettingsError, match=r"expected a Camera, by Camera\.perspective"):
            as_camera(source)


def test_axes_of_opencv() -> None:
    assert np.allclose(Camera.from_intrinsics(K, SIZE, pose=POSES[0] @ TURN, axes="opencv").pose, POSES[0])


@pytest.mark.gl
def test_arrays_take_them() -> None:
    """A calibration matrix alone is for the depth's own size."""
    depth = np.full((48, 64), 2.0, np.float32)
    depth[:, 32:] = 1.9
    k = np.diag([50.0, 50, 1]) + [[0, 0, 32], [0, 0, 24], [0, 0, 0]]
    right = ao.occlusion(depth, Camera.pinhole(50, 50, 32, 24, (64, 48)), method=ao.Bitmask(radius=0.3))
    assert right.min() < 0.9
    assert np.array_equal(ao.occlusion(depth, k, method=ao.Bitmask(radius=0.3)), right)
