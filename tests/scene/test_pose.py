"""Poses in everybody's axes; matrices that do more than turn and move are refused in one line."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from ssao_gl.errors import SettingsError
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lens import CropLens
from ssao_gl.scene.pose import TURN, look_at, pose_of

SIZE = (640, 480)
POSE = look_at((1, 2, 3), (0, 0.5, -1), (0.1, 1, 0))
K = np.array([[500.0, 0, 310], [0, 510, 250], [0, 0, 1]])


def seen_at(camera: Camera, point: Any) -> Any:
    """Pixel of a point of the world, by the intrinsics and extrinsics that the camera gives."""
    p = camera.world_to_camera @ [*point, 1]
    q = camera.intrinsics(SIZE) @ p[:3]
    return q[:2] / q[2]


def projected(camera: Camera, point: Any) -> Any:
    """The same by the projection that is drawn with."""
    clip = camera.lens.matrix(SIZE) @ np.linalg.inv(camera.pose) @ [*point, 1]
    ndc = clip[:2] / clip[3]
    return np.array([(1 + ndc[0]) / 2 * SIZE[0], (1 - ndc[1]) / 2 * SIZE[1]])


CAMERAS = {
    "perspective": Camera.perspective(0.8, pose=POSE),
    "pinhole": Camera.from_intrinsics(K, SIZE, pose=POSE),
    "other size": Camera.pinhole(250, 255, 155, 125, (320, 240), pose=POSE),
    "matrix": Camera.from_matrix(Camera.from_intrinsics(K, SIZE).lens.matrix(SIZE), POSE),
}


@pytest.mark.parametrize("name", CAMERAS)
def test_intrinsics_and_extrinsics_project_as_the_camera_does(name: str) -> None:
    for point in ((0, 0, 0), (0.3, 0.7, -1), (-1, 0.2, 0.4)):
        assert np.allclose(seen_at(CAMERAS[name], point), projected(CAMERAS[name], point), atol=1e-9)
    if name != "perspective":
        assert np.allclose(CAMERAS[name].intrinsics(SIZE), K)


def test_axes() -> None:
    extrinsic = Camera.from_intrinsics(K, SIZE, pose=POSE).world_to_camera
    assert np.linalg.det(extrinsic[:3, :3]) == pytest.approx(1)
    same = (
        pose_of(POSE),
        pose_of(POSE @ TURN, axes="opencv"),
        pose_of(None, extrinsic),
        pose_of(None, extrinsic[:3]),
        pose_of(None, np.linalg.inv(POSE), "opengl"),
    )
    for one in same:
        assert np.allclose(one, POSE)
    assert np.allclose(Camera.pinhole(1, 1, 1, 1, (2, 2), world_to_camera=extrinsic).pose, POSE)


@pytest.mark.parametrize("name", [*CAMERAS, "orthographic"])
def test_json_round_trip(name: str) -> None:
    camera = CAMERAS.get(name) or Camera.orthographic(3, 0.1, 9, POSE)
    again = Camera.from_json(camera.named("front").to_json())
    assert again.name == "front" and np.array_equal(again.pose, camera.pose)
    assert np.allclose(again.lens.matrix(SIZE), camera.lens.matrix(SIZE), rtol=1e-12)
    assert Camera.from_json(json.loads(again.to_json())).to_json() == again.to_json()


BAD_POSES: dict[str, tuple[Any, str]] = {
    "zeros": (np.zeros((4, 4)), "last row of pose must be 0 0 0 1"),
    "singular": (np.diag([1.0, 0, 1, 1]), "scales by 1, 1, 0"),
    "scaled": (np.diag([2.0, 2, 2, 1]), "must turn and move only; its upper left 3x3 block scales by 2, 2, 2"),
    "mirrored": (np.diag([1.0, -1, 1, 1]), "mirrors"),
    "nan": (np.full((4, 4), np.nan), r"finite \(4, 4\)"),
    "shape": (np.eye(3), r"got shape \(3, 3\)"),
    "transposed": (POSE.T, "last row"),
    "words": ([["a"] * 4] * 4, "of numbers"),
    "ragged": ([[1], [1, 2]], "of numbers"),
}


@pytest.mark.parametrize("case", BAD_POSES)
def test_poses_that_do_not_turn_and_move(case: str) -> None:
    values, text = BAD_POSES[case]
    for use in (lambda: Camera.perspective(1.0, pose=values), lambda: Camera(CAMERAS["pinhole"].lens, values)):
        with pytest.raises(SettingsError, match=text) as error:
            use()
        assert "\n" not in str(error.value)
    with pytest.raises(SettingsError):
        Camera.pinhole(1, 1, 1, 1, (2, 2), world_to_camera=values)


def test_rounded_rotations_pass() -> None:
    assert Camera.perspective(1.0, pose=np.round(POSE, 4)).pose.shape == (4, 4)


@pytest.mark.parametrize(
    ("k", "text"),
    [
        (np.eye(4), r"\(3, 3\) matrix"),
        (K.T, "transposed"),
        (K + [[0, 9, 0], [0, 0, 0], [0, 0, 0]], "skew"),
        (-K + np.diag([0, 0, 2.0]), "above 0"),
        ("K", r"\(3, 3\) matrix"),
    ],
)
def test_calibrations_that_are_none(k: Any, text: str) -> None:
    with pytest.raises(SettingsError, match=text):
        Camera.from_intrinsics(k, SIZE)


def test_what_cannot_be_asked() -> None:
    with pytest.raises(SettingsError, match="perspective cameras only"):
        Camera.orthographic(2, 0.1, 9).intrinsics(SIZE)
    with pytest.raises(SettingsError, match="cannot be written"):
        Camera(CropLens(CAMERAS["pinhole"].lens, SIZE, (0, 0))).to_json()
    with pytest.raises(SettingsError, match="not both"):
        Camera.from_intrinsics(K, SIZE, pose=POSE, world_to_camera=POSE)
    with pytest.raises(SettingsError, match="axes='blender'"):
        Camera.from_intrinsics(K, SIZE, axes="blender")  # type: ignore[arg-type]
    for text, what in (
        ("[]", "expected an object"),
        ("{", "Expecting"),
        ('{"pose": []}', "pose"),
        ('{"eye": [0,0,1]}', "lacks"),
    ):
        with pytest.raises(SettingsError, match=what):
            Camera.from_json(text)
