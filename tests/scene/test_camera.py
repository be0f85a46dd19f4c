"""Cameras: reconstruction inverts projection, whatever the lens. No OpenGL."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.errors import SettingsError
from ssao_gl.gl.depth_range import fit_depth_range
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.pose import look_at
from ssao_gl.scene.projection import Matrix, ViewConstants

SIZE = (320, 200)


def reversed_infinite(f: float = 1.5, n: float = 0.1) -> Matrix:
    return np.array([[f, 0, 0.1, 0], [0, f, -0.2, 0], [0, 0, 0, n], [0, 0, -1, 0.0]])


def rotated(projection: Matrix) -> Matrix:
    """The image turned by 90 degrees, as tablets in portrait hand it over."""
    turn = np.eye(4)
    turn[:2, :2] = [[0, -1], [1, 0]]
    return turn @ projection


LENSES = {
    "perspective": Camera.perspective(1.0, 0.1, 50.0),
    "infinite": Camera.perspective(0.3, 0.01),
    "orthographic": Camera.orthographic(4.0, 0.1, 50.0),
    "pinhole": Camera.pinhole(300, 310, 100.0, 140.0, SIZE),
    "reversed infinite": Camera.from_matrix(reversed_infinite(), clip="0..1"),
    "rotated": Camera.from_matrix(rotated(Camera.perspective(1.0, 0.1, 50.0).lens.matrix(SIZE))),
    "oblique parallel": Camera.from_matrix(
        np.array([[0.5, 0, 0.2, 0.1], [0, 0.7, -0.1, 0], [0, 0, -0.04, -1.0], [0, 0, 0, 1.0]])
    ),
    "oblique near plane": Camera.from_matrix(
        np.array([[1.5, 0, 0.1, 0], [0, 2.0, -0.2, 0], [0.05, -0.08, -1.0, -0.2], [0, 0, -1.0, 0]])
    ),
}


def project(view: ViewConstants, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    clip = np.column_stack([points, np.ones(len(points))]) @ view.projection.T
    return clip[:, :3] / clip[:, 3:], clip[:, 3]


@pytest.mark.parametrize("name", LENSES)
def test_points_invert_projection(name: str) -> None:
    view = LENSES[name].view(SIZE)
    rng = np.random.default_rng(1)
    z = rng.uniform(0.5, 20, SIZE[::-1])
    points = view.points(z)
    ndc, _ = project(view, points.reshape(-1, 3))
    u, v = np.meshgrid((np.arange(SIZE[0]) + 0.5) / SIZE[0], 1 - (np.arange(SIZE[1]) + 0.5) / SIZE[1])
    np.testing.assert_allclose(ndc[:, :2], np.stack([2 * u - 1, 2 * v - 1], -1).reshape(-1, 2), atol=1e-9)
    np.testing.assert_allclose(-points[..., 2], z)


@pytest.mark.parametrize("name", LENSES)
def test_window_depth_inverts(name: str) -> None:
    view = LENSES[name].view(SIZE)
    z = np.linspace(max(view.near * 1.01, 0.2), min(view.far, 40) * 0.99, 50)
    uv = np.full((50, 2), 0.3)
    c = view.constants
    xy = (uv @ np.reshape(c["u_ray"], (2, 2)) + c["u_ray0"]) * z[:, None] + uv @ np.reshape(c["u_org"], (2, 2)) + c["u_org0"]
    ndc, _ = project(view, np.column_stack([xy, -z]))
    d = view.depth_constants
    p = np.column_stack([uv, (ndc[:, 2] + 1) / 2 - d["u_depth_far"], np.ones(50)])
    np.testing.assert_allclose((p @ d["u_depth_num"]) / (p @ d["u_depth_den"]), z, rtol=1e-9)


@pytest.mark.parametrize("name", LENSES)
def test_an_offset_parallel_to_the_image_moves_uv_as_promised(name: str) -> None:
    view = LENSES[name].view(SIZE)
    p, offset = np.array([0.3, -0.2, -5.0]), np.array([0.04, 0.07])
    ndc, w = project(view, np.stack([p, p + [*offset, 0]]))
    moved = np.reshape(view.constants["u_uv_per_unit"], (2, 2)).T @ offset / w[0]
    np.testing.assert_allclose((ndc[1, :2] - ndc[0, :2]) / 2, moved, atol=1e-12)
    assert w[0] == pytest.approx(view.w1 * 5 + view.w0)


def test_near_and_far_are_found_in_any_convention() -> None:
    assert LENSES["perspective"].view(SIZE).near == pytest.approx(0.1)
    assert LENSES["perspective"].view(SIZE).far == pytest.approx(50)
    assert math.isinf(LENSES["infinite"].view(SIZE).far)
    flipped = LENSES["reversed infinite"].view(SIZE)
    assert flipped.near == pytest.approx(0.1) and math.isinf(flipped.far)
    assert (LENSES["orthographic"].view(SIZE).near, LENSES["orthographic"].view(SIZE).far) == pytest.approx((0.1, 50))


@pytest.mark.parametrize("name", LENSES)
def test_the_depth_row_is_rebuilt_and_nothing_else(name: str) -> None:
    view = LENSES[name].view(SIZE)
    fitted = fit_depth_range(view, 3.0, 9.0)
    np.testing.assert_array_equal(fitted[[0, 1, 3]], view.projection[[0, 1, 3]])
    for z, expected in ((3.0, -1), (9.0, 1)):
        clip = fitted @ [0, 0, -z, 1]
        assert clip[2] / clip[3] == pytest.approx(expected, abs=0.02)


def test_opencv_extrinsics_and_intrinsics() -> None:
    """A point in OpenCV's camera (x right, y down, z forward) lands on the pixel that fx, fy, cx, cy say."""
    world_to_camera = np.eye(4)
    world_to_camera[:3, 3] = [0.1, -0.2, 0.3]
    camera = Camera.pinhole(300, 310, 100.0, 140.0, SIZE, world_to_camera=world_to_camera)
    point = np.array([0.2, 0.4, 3.0])
    x, y, z = world_to_camera[:3] @ [*point, 1]
    pixel = 300 * x / z + 100, 310 * y / z + 140
    view_point = (np.linalg.inv(camera.pose) @ [*point, 1])[:3]
    ndc, _ = project(camera.view(SIZE), view_point[None])
    found = (ndc[0, 0] + 1) / 2 * SIZE[0], (1 - ndc[0, 1]) / 2 * SIZE[1]
    assert found == pytest.approx(pixel)


@given(st.tuples(*[st.floats(-10, 10)] * 3), st.tuples(*[st.floats(-10, 10)] * 3))
def test_look_at_is_a_rotation_that_looks_at_its_target(eye: tuple[float, ...], target: tuple[float, ...]) -> None:
    try:
        pose = look_at(eye, target)
    except SettingsError:
        offset = np.subtract(target, eye)
        assert np.linalg.norm(np.cross(offset, [0, 1, 0])) <= 1e-9 * max(1, np.linalg.norm(offset))
        return
    rotation = pose[:3, :3]
    np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) > 0
    seen = np.linalg.inv(pose) @ [*target, 1]
    np.testing.assert_allclose(seen[:2], 0, atol=1e-8)
    assert seen[2] < 0


@pytest.mark.parametrize(
    "make",
    [
        lambda: Camera.perspective(0, 0.1),
        lambda: Camera.perspective(math.pi, 0.1),
        lambda: Camera.perspective(1, 0),
        lambda: Camera.perspective(1, 1, 0.5),
        lambda: Camera.orthographic(0, 0, 1),
        lambda: Camera.from_matrix(np.zeros((4, 4))).view(SIZE),
        lambda: Camera.from_matrix(np.full((4, 4), np.nan)),
        lambda: Camera.from_matrix(np.eye(3)),
        lambda: Camera.from_matrix(np.eye(4), clip="nonsense"),  # type: ignore[arg-type]
        lambda: Camera.from_matrix(np.diag([1, 1, 1, 0]) + np.eye(4, k=-1)).view(SIZE),
        lambda: look_at((0, 0, 0), (0, 0, 0)),
        lambda: look_at((0, 0, 0), (0, 1, 0)),
    ],
)
def test_unusable_cameras_say_so(make: object) -> None:
    with pytest.raises(SettingsError, match="camera"):
        make()  # type: ignore[operator]


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1.0, 1e6, 1e12])
def test_look_at_asks_for_directions_and_not_for_lengths(size: float) -> None:
    pose = look_at(np.multiply(size, (3, 4, 5)), (0, 0, 0), (0, 1 / size, 0))
    np.testing.assert_allclose(pose[:3, :3], look_at((3, 4, 5), (0, 0, 0))[:3, :3], atol=1e-12)
    with pytest.raises(SettingsError, match="up is parallel"):
        look_at((0, size, 0), (0, 0, 0), (0, 1 / size, 0))


def test_the_rays_of_a_pinhole_meet_in_the_eye() -> None:
    """Shaders leave out what only other projections need."""
    for name, camera in LENSES.items():
        view = camera.view(SIZE)
        eye = view.points(np.full(SIZE[::-1], 1e-9))
        assert view.pinhole == (np.abs(eye).max() < 1e-6), name
    for row in (0, 1):
        matrix = LENSES["perspective"].lens.matrix(SIZE).copy()
        matrix[row, 3] = 0.3
        assert not Camera.from_matrix(matrix).view(SIZE).pinhole
    assert {name for name, camera in LENSES.items() if not camera.view(SIZE).pinhole} == {"orthographic", "oblique parallel"}
