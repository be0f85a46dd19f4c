"""The G-buffer: depth in scene units, normals to the viewer, colour, instances; normals rebuilt from depth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import DEPTH, DEPTH_LAYER_2
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.sample_scene import sphere

from ..shapes import camera, look_at, plane, quad

SIZE = (128, 96)
ALL = ("image", "visibility", "depth", "normal", "color")


def shot(renderer: ao.Renderer, scene: Scene, cam: Camera, aovs: tuple[str, ...] = ("depth", "normal", "color")) -> ao.Picture:
    return renderer.render(scene, cam, SIZE, aovs=aovs, checked=True)


@pytest.mark.parametrize("tilt", [0.0, 0.5, -1.3])
def test_depth_and_normal_of_a_plane(renderer: ao.Renderer, tilt: float) -> None:
    cam = camera()
    picture = shot(renderer, plane(tilt), cam)
    normal = np.array([0, -np.sin(tilt), np.cos(tilt)])
    rays = cam.view(SIZE).points(np.ones(SIZE[::-1]))
    expected = -5 * normal[2] / (rays @ normal)
    seen = picture.depth > 0
    assert seen.any()
    # SwiftShader snaps vertices to a sixteenth of a pixel, which tilts large triangles a little.
    exact = "SwiftShader" not in renderer.ctx.renderer
    np.testing.assert_allclose(picture.depth[seen], expected[seen], rtol=2e-6 if exact else 1e-2)
    facing = np.where((rays @ normal)[..., None] > 0, -normal, normal)
    np.testing.assert_allclose(picture.normal[seen], facing[seen], atol=6e-4)


def test_a_picture_is_the_right_way_up_and_not_mirrored(renderer: ao.Renderer) -> None:
    red, green, blue = (1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)
    draws = [
        dataclasses.replace(quad((x, y, -5), (0.3, 0, 0), (0, 0.3, 0)), color=color)
        for x, y, color in ((-1, 1, red), (1, 1, green), (-1, -1, blue))
    ]
    color = shot(renderer, Scene(draws), camera()).color.astype(int)
    top, bottom, left, right = slice(0, 48), slice(48, 96), slice(0, 64), slice(64, 128)
    for where, channel in (((top, left), 0), ((top, right), 1), ((bottom, left), 2)):
        assert (color[where][..., channel] - color[where].sum(-1) / 3).max() > 100
    assert (color[bottom, right] == 255).all()


def test_background_is_exact(renderer: ao.Renderer) -> None:
    scene = Scene([quad((0, 0, -5), (0.5, 0, 0), (0, 0.5, 0))])
    settings = ao.Settings(shading=ao.Shading(background="#204060"))
    picture = renderer.render(scene, camera(), SIZE, settings, aovs=ALL)
    sky = picture.depth == 0
    assert 0.5 < sky.mean() < 1
    assert (picture.visibility[sky] == 1).all() and (picture.normal[sky] == 0).all()
    assert (picture.image[sky] == [0x20, 0x40, 0x60]).all() and (picture.color[sky] == 255).all()


def test_the_default_background_is_of_the_image_alone(renderer: ao.Renderer) -> None:
    """A scene without one gets the calm colour, a scene with one its own; other buffers stay as they are."""
    scene = Scene([quad((0, 0, -5), (0.5, 0, 0), (0, 0.5, 0))])
    plain, white = renderer.render(scene, camera(), SIZE, aovs=ALL), ao.Settings(shading=ao.Shading(background="white"))
    own = renderer.render(dataclasses.replace(scene, background=(0.0, 0.0, 1.0, 1.0)), camera(), SIZE, aovs=ALL)
    old = renderer.render(dataclasses.replace(scene, background=(0.0, 0.0, 1.0, 1.0)), camera(), SIZE, white, aovs=ALL)
    sky = plain.depth == 0
    for picture, color in ((plain, [0x9A, 0xA5, 0xB1]), (own, [0, 0, 255]), (old, [255, 255, 255])):
        assert (picture.image[sky] == color).all()
        assert np.array_equal(picture.image[~sky], plain.image[~sky])
        for name in set(ALL) - {"image"}:
            assert np.array_equal(picture.arrays[name], plain.arrays[name]), name
    assert own.report["settings"]["shading"]["background"] == "#0000ffff"


@pytest.mark.parametrize("keep", [(), ("background",)])
def test_a_transparent_background(renderer: ao.Renderer, keep: tuple[str, ...]) -> None:
    """RGBA, alpha 0 behind the scene and 255 on it; when asked for, or when the scene's own is."""
    scene = Scene([quad((0, 0, -5), (0.5, 0, 0), (0, 0.5, 0))])
    settings = ao.Settings(shading=ao.Shading(background="transparent"), keep=keep)
    clear = renderer.render(scene, camera(), SIZE, settings, aovs=("image", "depth", "color"))
    opaque = renderer.render(scene, camera(), SIZE, aovs=("image",))
    sky = clear.depth == 0
    assert clear.image.shape == (*sky.shape, 4) and clear.color.shape == (*sky.shape, 3)
    assert (clear.image[sky] == 0).all() and (clear.image[~sky][:, 3] == 255).all()
    assert np.array_equal(clear.image[~sky][:, :3], opaque.image[~sky])
    own = renderer.render(dataclasses.replace(scene, background=(0.0, 0.0, 0.0, 0.0)), camera(), SIZE)
    assert np.array_equal(own.image, clear.image)


def test_an_instance_is_drawn_for_each_transform(renderer: ao.Renderer) -> None:
    positions, triangles, normals = sphere(32)
    places = np.stack([np.eye(4)] * 3)
    places[:, 0, 3] = [-2, 0, 2]
    places[:, 2, 3] = -8
    places[1] = places[1] @ np.diag([1, -1, 1, 1])  # mirrored
    places[2] = places[2] @ np.diag([1, 0.25, 0.5, 1])  # squashed
    picture = shot(renderer, Scene([Mesh(positions, triangles, normals, transforms=places)]), camera())
    seen = picture.depth > 0
    points, normals_seen = camera().view(SIZE).points(picture.depth)[seen], picture.normal[seen]
    nearest = np.argmin([np.linalg.norm(points - place[:3, 3], axis=1) for place in places], axis=0)
    for index, place in enumerate(places):
        mine = nearest == index
        assert mine.sum() > 50
        local = (points[mine] - place[:3, 3]) @ np.linalg.inv(place[:3, :3]).T
        np.testing.assert_allclose(np.linalg.norm(local, axis=1), 1, atol=0.03)
        expected = local @ np.linalg.inv(place[:3, :3])
        expected /= np.linalg.norm(expected, axis=1, keepdims=True)
        facing = -(expected * points[mine]).sum(1) > 0.3 * np.linalg.norm(points[mine], axis=1)
        assert ((expected * normals_seen[mine]).sum(1)[facing] > 0.99).all()


def test_normals_turn_to_the_viewer_whatever_the_winding(renderer: ao.Renderer) -> None:
    wall = quad((0, 0, -5), (4, 0, 0), (0, 4, 0))
    away = dataclasses.replace(wall, normals=-wall.normals)  # type: ignore[operator]
    wound = dataclasses.replace(wall, triangles=wall.triangles[:, ::-1].copy())
    missing = dataclasses.replace(wall, normals=None)
    zero = dataclasses.replace(wall, normals=np.zeros((4, 3), np.float32))
    nan = dataclasses.replace(wall, normals=np.full((4, 3), np.nan, np.float32))
    for draw in (wall, away, wound, missing, zero, nan):
        normal = shot(renderer, Scene([draw]), camera()).normal[40:56, 50:78]
        np.testing.assert_allclose(normal, np.broadcast_to([0, 0, 1.0], normal.shape), atol=1e-3)


def test_vertex_colors_and_base_color_multiply(renderer: ao.Renderer) -> None:
    colors = np.full((4, 4), [200, 100, 50, 255], np.uint8)
    wall = dataclasses.replace(quad((0, 0, -5), (4, 0, 0), (0, 4, 0)), vertex_colors=colors, color=(0.5, 1.0, 1.0))
    assert np.abs(shot(renderer, Scene([wall]), camera()).color[48, 64].astype(int) - [100, 100, 50]).max() <= 1


def test_clip_planes_are_where_the_camera_puts_them(renderer: ao.Renderer) -> None:
    scene = Scene([quad((0, 0, -z), (40, 0, 0), (0, 40, 0)) for z in (1.0, 3.0, 9.0)])
    for near, far, expected in ((0.1, 40.0, 1.0), (2.0, 40.0, 3.0), (4.0, 40.0, 9.0), (2.0, 2.5, 0.0)):
        depth = shot(renderer, scene, Camera.perspective(0.9, near, far)).depth
        assert depth[48, 64] == pytest.approx(expected, rel=1e-6)


def test_a_reversed_infinite_projection_draws_the_nearest_too(renderer: ao.Renderer) -> None:
    scene = Scene([quad((0, 0, -z), (40, 0, 0), (0, 40, 0)) for z in (9.0, 3.0)])
    f = 1 / np.tan(0.45)
    m = np.array([[f * 96 / 128, 0, 0, 0], [0, f, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]])
    np.testing.assert_array_equal(
        shot(renderer, scene, Camera.from_matrix(m, clip="0..1")).depth,
        shot(renderer, scene, Camera.perspective(0.9, 0.1)).depth,
    )


def test_only_what_is_asked_for_is_there(renderer: ao.Renderer) -> None:
    picture = shot(renderer, plane(), camera(), ("depth",))
    assert set(picture.arrays) == {"depth"}
    with pytest.raises(AttributeError, match="ask for it"):
        _ = picture.normal


@pytest.mark.parametrize("parallel", [False, True], ids=["perspective", "parallel"])
def test_normals_from_depth_agree_with_the_mesh(renderer: ao.Renderer, embedded: Scene, parallel: bool) -> None:
    pose = embedded.cameras[0].pose
    cam = Camera.orthographic(5, 0, 30, pose) if parallel else embedded.cameras[0]
    size = (320, 240)
    truth = renderer.render(embedded, cam, size, aovs=("depth", "normal"))
    rebuilt = renderer.apply(truth.depth, cam, settings=ao.Settings(method=ao.Alchemy(radius=0.5), blur=None), checked=True)
    seen = truth.depth > 0
    cosine = (rebuilt.normal * truth.normal).sum(-1)[seen]
    assert (cosine > np.cos(np.radians(6))).mean() > 0.92  # facets of round things differ from their smooth normals
    np.testing.assert_array_equal(rebuilt.depth, truth.depth)


def test_normals_from_depth_are_exact_on_planes(renderer: ao.Renderer) -> None:
    """Also at grazing angles, and up to the edges of the image."""
    for tilt in (0.0, 0.9, -1.45):
        truth = renderer.render(plane(tilt), camera(), SIZE, aovs=("depth", "normal"))
        rebuilt = renderer.apply(truth.depth, camera(), settings=ao.Settings(method=ao.Alchemy(radius=0.5), blur=None))
        both = truth.depth > 0
        assert ((rebuilt.normal * truth.normal).sum(-1)[both] > np.cos(2e-3)).all()


def test_broken_texels_become_background(renderer: ao.Renderer) -> None:
    depth = np.full((64, 64), 5.0, np.float32)
    depth[8] = [np.nan, np.inf, -np.inf, -1.0, 0.0, 1e38, 1e-42, 5.0] * 8
    with pytest.warns(ao.InputWarning, match="8 of 4096 depths have the wrong sign"):
        picture = renderer.apply(depth, camera(), settings=ao.Settings(method=ao.Alchemy(radius=1.0)), checked=True)
    assert np.isfinite(picture.visibility).all()
    assert (picture.depth[8].reshape(8, 8)[:, :6] == 0).all() and (picture.depth[8].reshape(8, 8)[:, 7] == 5).all()
    assert (picture.visibility[picture.depth == 0] == 1).all()


def test_look_from_inside_a_mesh(renderer: ao.Renderer, embedded: Scene) -> None:
    eye = (-1.7, 0.55, -1.6)  # inside the box
    cam = Camera.perspective(1.2, 0.01, 30.0, look_at(eye, (0, 0.5, 0)))
    picture = renderer.render(embedded, cam, SIZE, aovs=ALL, checked=True)
    assert (picture.depth > 0).all() and np.isfinite(picture.visibility).all()


TILTS = (0.0, 0.5, 1.3)


def second_layer(renderer: ao.Renderer, scene: Scene, radius: float = 1e-6, scale: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Depths of the first layer and of the one behind it, by half a radius."""
    settings = ao.Settings(method=ao.Bitmask(scale=1, layers=2, layer_scale=scale, radius=radius, guard=0), blur=None)
    first, second = (renderer.resource(scene, camera(), SIZE, settings, name) for name in (DEPTH, DEPTH_LAYER_2))
    assert first is not None and second is not None
    return first[..., 0], second[..., 0]


def sheet(tilt: float, behind: float = 0.0) -> Mesh:
    """Part of a tilted plane, farther away by a share of its distance to the eye at every pixel."""
    corners = np.array([(-8, -1, 0), (8, -1, 0), (8, 1, 0), (-8, 1, 0)], np.float64)
    corners[:, 1:] = corners[:, 1:2] * [np.cos(tilt), np.sin(tilt)] + [0, -5]
    return Mesh((corners * (1 + behind)).astype(np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32))


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("behind", [4e-5, 1e-3, 0.1])
def test_a_second_layer_begins_right_behind_the_first(renderer: ao.Renderer, tilt: float, behind: float) -> None:
    if "SwiftShader" in renderer.ctx.renderer and behind < 1e-3:
        pytest.skip("it snaps vertices, which tilts large triangles by more than that")
    first, second = second_layer(renderer, Scene([sheet(tilt), sheet(tilt, behind)]))
    alone, _ = second_layer(renderer, Scene([sheet(tilt)]))
    there = (alone > 0) & (second > 0)
    assert there.sum() >= 0.9 * (alone > 0).sum() > 100
    np.testing.assert_allclose(second[there], first[there] * (1 + behind), rtol=1e-5 if behind < 0.01 else 1e-3)


def test_a_second_layer_begins_half_a_radius_behind_the_first(renderer: ao.Renderer) -> None:
    scene = Scene([sheet(0), sheet(0, 0.1)])  # half a unit behind
    first, near = second_layer(renderer, scene, radius=0.9)
    _, far = second_layer(renderer, scene, radius=1.1)
    assert (first > 0).sum() > 100 and (near > 0).sum() > 100 and not far.any()


@pytest.mark.parametrize("scale", [2, 4])
@pytest.mark.parametrize("size", [SIZE, (SIZE[0] + 1, SIZE[1] - 1)])
def test_a_smaller_second_layer_has_pixels_of_the_whole_one(
    renderer: ao.Renderer, embedded: Scene, scale: int, size: tuple[int, int]
) -> None:
    """Each texel that of the pixel in its middle, whatever the size of the image."""
    found = {}
    for step in (1, scale):
        settings = ao.Settings(method=ao.Bitmask(scale=1, layers=2, layer_scale=step, radius=0.1, guard=0), blur=None)
        texels = renderer.resource(embedded, embedded.cameras[0], size, settings, DEPTH_LAYER_2)
        assert texels is not None
        found[step] = texels[..., 0]
    rows, columns = (slice(scale // 2, None, scale) for _ in range(2))
    whole = found[1][rows, columns]
    small = found[scale][: whole.shape[0], : whole.shape[1]]
    assert (whole > 0).sum() > 50
    same = np.isclose(small, whole, rtol=1e-3)  # SwiftShader snaps vertices
    assert same.mean() > 0.95, "but where an edge runs through the middle of a pixel"


@pytest.mark.parametrize("tilt", TILTS)
def test_a_surface_is_not_behind_itself(renderer: ao.Renderer, tilt: float) -> None:
    """Nor is its like in other triangles, whose depths are rounded otherwise."""
    one = sheet(tilt)
    crossed = dataclasses.replace(one, triangles=np.array([[1, 2, 3], [1, 3, 0]], np.uint32))
    middle = np.concatenate([one.positions, one.positions[:3:2].mean(0, keepdims=True)])
    fan = Mesh(middle.astype(np.float32), np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], np.uint32))
    copies = [one] if "SwiftShader" in renderer.ctx.renderer else [one, crossed, fan]
    first, second = second_layer(renderer, Scene(copies))
    assert (first > 0).sum() > 100 and not second.any()
