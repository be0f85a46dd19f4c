"""Properties of cameras and kernels for any parameters, found by Hypothesis. No OpenGL.

Of frame graphs and of what people type, see test_properties_graph.py and test_properties_input.py.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ssao_gl.errors import SettingsError
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lens import CropLens
from ssao_gl.scene.projection import Matrix, ViewConstants

SIDES = st.integers(1, 5000)
SIZES = st.tuples(SIDES, SIDES)
NEAR = st.floats(-4, 3).map(lambda e: 10**e)
RATIO = st.floats(0.01, 7).map(lambda e: 10**e)
"""far : near."""


# Lenses


@st.composite
def frustums(draw: st.DrawFn) -> Matrix:
    """Any OpenGL frustum: off-centre, with an infinite far plane, reversed, with clip depths from -1 or from 0."""
    near = draw(NEAR)
    left, bottom = (near * draw(st.floats(-3, 2)) for _ in range(2))
    right, top = left + near * draw(st.floats(0.01, 4)), bottom + near * draw(st.floats(0.01, 4))
    far = draw(st.one_of(st.just(math.inf), RATIO.map(lambda r: near * r)))
    m = np.zeros((4, 4))
    m[0, 0], m[0, 2] = 2 * near / (right - left), (right + left) / (right - left)
    m[1, 1], m[1, 2] = 2 * near / (top - bottom), (top + bottom) / (top - bottom)
    m[2, 2], m[2, 3] = (-1, -2 * near) if far == math.inf else ((far + near) / (near - far), 2 * far * near / (near - far))
    m[3, 2] = -1
    if draw(st.booleans()):
        m[2] = -m[2]
    return m


@st.composite
def cameras(draw: st.DrawFn) -> Camera:
    """Of every kind, and parts of them, and images turned by a quarter."""
    kind = draw(st.sampled_from(["perspective", "orthographic", "pinhole", "frustum"]))
    near = draw(NEAR)
    far = draw(st.one_of(st.none(), RATIO.map(lambda r: near * r)))
    if kind == "perspective":
        camera = Camera.perspective(draw(st.floats(1e-3, 3.1)), near, far)
    elif kind == "orthographic":
        camera = Camera.orthographic(draw(NEAR), -near if draw(st.booleans()) else near, 2 * near if far is None else far)
    elif kind == "pinhole":
        fx, fy = (draw(st.floats(1, 1e5)) for _ in range(2))
        cx, cy = (draw(st.floats(-1e4, 1e4)) for _ in range(2))
        camera = Camera.pinhole(fx, fy, cx, cy, draw(SIZES), znear=near, zfar=far)
    else:
        matrix = draw(frustums())
        turn = draw(st.sampled_from([(1, 0), (0, 1), (-1, 0), (0, -1)]))
        matrix[:2] = np.array([turn, (-turn[1], turn[0])]) @ matrix[:2]
        clip = draw(st.sampled_from(["-1..1", "0..1"]))
        if clip == "0..1":
            matrix[2] = (matrix[2] + matrix[3]) / 2
        camera = Camera.from_matrix(matrix, clip=clip)
    if draw(st.booleans()):
        corner = draw(st.integers(-50, 5000)), draw(st.integers(-50, 5000))
        camera = dataclasses.replace(camera, lens=CropLens(camera.lens, draw(SIZES), corner))
    return camera


def project(view: ViewConstants, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normalised device coordinates (n, 3), and clip w."""
    clip = np.column_stack([points, np.ones(len(points))]) @ view.projection.T
    return clip[:, :3] / clip[:, 3:], clip[:, 3]


def unproject(view: ViewConstants, uv: np.ndarray, z: np.ndarray) -> np.ndarray:
    """View-space points (n, 3) by the constants that shaders get."""
    c = view.constants
    xy = (uv @ np.reshape(c["u_ray"], (2, 2)) + c["u_ray0"]) * z[:, None]
    return np.column_stack([xy + uv @ np.reshape(c["u_org"], (2, 2)) + c["u_org0"], -z])


UV = st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=8).map(np.array)
DEPTH = st.floats(0, 1)


def between(view: ViewConstants, share: float) -> float:
    """A depth between the clip planes, evenly in its logarithm where they allow that."""
    near, far = view.near, min(view.far, max(1e6 * abs(view.near), view.near + 1))
    return near * (far / near) ** share if near > 0 else near + (far - near) * share


@given(cameras(), SIZES, UV, DEPTH)
def test_reconstruction_inverts_projection(camera: Camera, size: tuple[int, int], uv: np.ndarray, share: float) -> None:
    view = camera.view(size)
    z = np.full(len(uv), between(view, share))
    assume(abs(view.w1 * z[0] + view.w0) > 1e-300)
    ndc, w = project(view, unproject(view, uv, z))
    offset = np.abs(view.projection[:2, 2:]).max(1) / np.abs(view.projection[:2, :2]).max(1)
    np.testing.assert_allclose(
        (ndc[:, :2] + 1) / 2, uv, atol=1e-9 * (1 + np.abs(view.projection[:2]).max() * (1 + offset.max()))
    )
    np.testing.assert_allclose(w, view.w1 * z + view.w0, rtol=1e-12)


@given(cameras(), SIZES, UV, DEPTH)
def test_window_depth_inverts(camera: Camera, size: tuple[int, int], uv: np.ndarray, share: float) -> None:
    view = camera.view(size)
    z = np.full(len(uv), between(view, share))
    ndc, _ = project(view, unproject(view, uv, z))
    d = view.depth_constants
    p = np.column_stack([uv, (ndc[:, 2] + 1) / 2 - d["u_depth_far"], np.ones(len(uv))])
    near, far = view.near, view.far
    ratio = 1e6 if math.isinf(far) else max(abs(far / near), 1) if near else 1e6
    np.testing.assert_allclose(
        (p @ d["u_depth_num"]) / (p @ d["u_depth_den"]),
        z,
        rtol=1e-13 * ratio + 1e-9,
        atol=1e-9 * abs(far - near) if view.w1 == 0 else 0,
    )


@given(cameras(), SIZES, UV, DEPTH, st.floats(0, 2 * math.pi))
def test_offsets_parallel_to_the_image(
    camera: Camera, size: tuple[int, int], uv: np.ndarray, share: float, angle: float
) -> None:
    """Move ``uv`` by ``uv_per_unit @ d / w``, which is how shaders find the reach of a radius."""
    view = camera.view(size)
    z = np.full(len(uv), between(view, share))
    points = unproject(view, uv, z)
    offset = view.pixel * abs(view.w1 * z[0] + view.w0) * np.array([math.cos(angle), math.sin(angle)])
    before, w = project(view, points)
    after, _ = project(view, points + [*offset, 0])
    moved = np.reshape(view.constants["u_uv_per_unit"], (2, 2)).T @ offset / w[0]
    scale = 1 + np.abs(view.projection[:2]).max() / np.abs(view.projection[:2, :2]).max()
    np.testing.assert_allclose((after - before)[:, :2] / 2, np.tile(moved, (len(uv), 1)), atol=1e-9 * scale)
    assert np.linalg.norm(moved * size) >= 0.999, "the size of a pixel is that of its longer side"


@given(NEAR, st.one_of(st.none(), RATIO), SIZES, st.floats(1e-3, 3.1), st.booleans(), st.sampled_from(["-1..1", "0..1"]))
def test_clip_planes_are_found_in_any_convention(
    near: float, ratio: float | None, size: tuple[int, int], yfov: float, flip: bool, clip: Any
) -> None:
    far = None if ratio is None else near * ratio
    matrix = Camera.perspective(yfov, near, far).lens.matrix(size)
    if flip:
        matrix[2] *= -1
    if clip == "0..1":
        matrix[2] = (matrix[2] + matrix[3]) / 2
    view = Camera.from_matrix(matrix, clip=clip).view(size)
    assert view.near == pytest.approx(near, rel=1e-6)
    if far is None:
        assert math.isinf(view.far)
    else:
        assert view.far == pytest.approx(far, rel=1e-14 * (far / near) ** 2 + 1e-6) or far / near > 1e6
    assert (view.depth_constants["u_depth_far"] == 1) != flip


@given(
    st.tuples(*[st.floats(10, 1e4)] * 2), st.tuples(*[st.floats(-500, 4000)] * 2), SIZES, SIZES,
    st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(0.5, 20)),
    st.tuples(*[st.floats(-3, 3)] * 6),
)  # fmt: skip
def test_pinhole_is_opencv(
    focal: tuple[float, float], centre: tuple[float, float], size: tuple[int, int], shown: tuple[int, int],
    point: tuple[float, float, float], motion: tuple[float, ...],
) -> None:  # fmt: skip
    """A point lands where OpenCV's formula puts it, for any extrinsics, and at the same place of the image at any size."""
    rotation = _rotation(np.array(motion[:3]))
    extrinsic = np.column_stack([rotation, motion[3:]])
    camera = Camera.pinhole(*focal, *centre, size, world_to_camera=extrinsic)
    world = rotation.T @ (np.array(point) - motion[3:])
    view_point = (np.linalg.inv(camera.pose) @ [*world, 1])[:3]
    np.testing.assert_allclose(view_point, np.array(point) * [1, -1, -1], atol=1e-9)
    ndc, _ = project(camera.view(shown), view_point[None])
    found = (ndc[0, 0] + 1) / 2 * size[0], (1 - ndc[0, 1]) / 2 * size[1]
    x, y, z = point
    assert found == pytest.approx((focal[0] * x / z + centre[0], focal[1] * y / z + centre[1]), rel=1e-9, abs=1e-6)


def _rotation(axis: np.ndarray) -> Matrix:
    """Rodrigues' formula."""
    angle = np.linalg.norm(axis)
    x, y, z = axis / angle if angle else axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k)


@given(cameras(), SIZES, st.tuples(st.integers(0, 99), st.integers(0, 99)), SIZES, UV, DEPTH)
def test_a_part_of_an_image_has_its_rays(
    camera: Camera, whole: tuple[int, int], corner: tuple[int, int], size: tuple[int, int], uv: np.ndarray, share: float
) -> None:
    """Tiles, and images with a border, see what the whole image sees at the same pixel."""
    view, part = camera.view(whole), Camera(CropLens(camera.lens, whole, corner)).view(size)
    z = np.full(len(uv), between(view, share))
    there = (np.array(corner) + uv * size) / whole
    a, b = unproject(part, uv, z), unproject(view, there, z)
    np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * np.abs(b).max())


ANY = st.floats()
"""All of them: NaN, infinity, negative, smaller and larger than can be."""


@given(st.sampled_from(["perspective", "orthographic", "pinhole", "matrix"]), st.lists(ANY, min_size=16, max_size=16), SIZES)
def test_a_camera_is_usable_or_refused(kind: str, values: list[float], size: tuple[int, int]) -> None:
    """In one line that says what. A usable one has constants that are finite as 32-bit floats, and clip planes in order."""
    try:
        if kind == "perspective":
            camera = Camera.perspective(values[0], values[1], values[2] if values[3] > 0 else None)
        elif kind == "orthographic":
            camera = Camera.orthographic(values[0], values[1], values[2])
        elif kind == "pinhole":
            camera = Camera.pinhole(*values[:4], size, znear=values[4], zfar=values[5])
        else:
            camera = Camera.from_matrix(np.reshape(values, (4, 4)))
        view = camera.view(size)
    except SettingsError as error:
        assert str(error).startswith("camera: ") and str(error).isprintable()
        return
    for name, constant in {**view.constants, **view.depth_constants}.items():
        with np.errstate(over="ignore"):
            assert np.isfinite(np.asarray(constant, np.float32)).all(), (name, constant)
    assert view.near < view.far and math.isfinite(view.near) and math.isfinite(view.pixel) and view.pixel > 0
    assert view.near > 0 or view.w1 == 0, "nothing is seen at the eye or behind it"


# Kernels
