"""Light: shadows against rays, light from all around against visibility, and what it costs where nobody asks for it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import BOUNCE, GAINED, MATERIAL, VISIBILITY
from ssao_gl.pipeline.build import plan_apply, plan_render
from ssao_gl.pipeline.light import Light, lit_view
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lamps import Lamp
from ssao_gl.scene.lens import CropLens
from ssao_gl.scene.material import Material
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.sample_scene import sphere
from ssao_gl.scene.srgb import decode, encode
from ssao_gl.truth.bounce import one_bounce
from ssao_gl.truth.shadows import shadows
from ssao_gl.truth.surface import surface

from ..shapes import look_at, quad

SIZE = (128, 96)
BARE = {"environment": "none", "specular": 0.0, "color": "#ffffff", "follows": "scene"}
"""A key light alone, on matt surfaces."""


def white(*meshes: Mesh) -> Scene:
    return Scene([dataclasses.replace(mesh, color=(1.0, 1.0, 1.0)) for mesh in meshes])


def floor(half: float = 4.0) -> Mesh:
    return quad((0, 0, 0), (0, 0, half), (half, 0, 0))


def above(distance: float = 8.0) -> Camera:
    return Camera.perspective(0.8, 0.1, 60.0, look_at((0.5 * distance, 0.7 * distance, 0.6 * distance), (0, 0.3, 0)))


def settings(**light: object) -> ao.Settings:
    return ao.Settings(method=ao.Bitmask(radius=0.5), shading=ao.Shading(background="black"), light=Light(**{**BARE, **light}))  # type: ignore[arg-type]


def linear(picture: ao.Picture) -> np.ndarray:
    return decode(picture.image[..., :3] / 255.0)


def post() -> list[Mesh]:
    return [quad((0, 1, 0), (0.07, 0, 0), (0, 1, 0)), quad((0, 1, 0), (0, 0, 0.07), (0, 1, 0))]


def ball() -> Mesh:
    place = np.diag([0.7, 0.7, 0.7, 1.0])
    place[:3, 3] = 0.3, 1.1, 0
    return Mesh(*sphere(48), transforms=place[None])


SHAPES = {
    "plane": white(floor()),
    "sphere": white(floor(), ball()),
    "post": white(floor(), *post()),
    "step": white(floor(), quad((0, 0.5, 0), (0, 0, 2), (0.7, 0, 0)), quad((0.7, 0.25, 0), (0, 0, 2), (0, 0.25, 0))),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("elevation", [4.0, 35.0, 80.0])
def test_shadows_are_those_of_rays(any_renderer: ao.Renderer, shape: str, elevation: float) -> None:
    scene, camera = SHAPES[shape], above()
    with_shadows = settings(azimuth=70.0, elevation=elevation, intensity=1.0, shadows=True, shadow_side=512)
    shadowed = linear(any_renderer.render(scene, camera, SIZE, with_shadows, checked=True))[..., 1]
    plain = linear(any_renderer.render(scene, camera, SIZE, settings(azimuth=70.0, elevation=elevation, intensity=1.0)))[..., 1]
    sun, view = lit_view(with_shadows.light, scene, camera, SIZE).eyes["key light"]
    texels = sun.pose[:3, :2] * (2 / (512 * np.diag(view.projection)[:2]))
    truth = shadows(surface(scene, camera, SIZE), sun.pose[:3, 2], 1.5 * texels.T)
    known = (plain > 0.002) & ~truth.edge
    lit = shadowed > 0.5 * plain
    assert known.mean() > 0.25
    assert (lit[known] != truth.lit[known]).mean() <= 0.005
    assert shape in ("plane", "step") or (known & ~truth.lit).any()


@pytest.mark.parametrize("elevation", [1.0, 10.0, 45.0, 89.0, 90.0])
def test_a_plane_has_no_acne(renderer: ao.Renderer, elevation: float) -> None:
    scene, camera = white(floor()), above()
    lamp = {"azimuth": 33.0, "elevation": elevation, "intensity": 0.9}
    pictures = [renderer.render(scene, camera, SIZE, settings(**lamp, shadows=on, shadow_side=256)) for on in (True, False)]
    np.testing.assert_array_equal(pictures[0].image, pictures[1].image)


def test_a_white_sky_gives_visibility(any_renderer: ao.Renderer, embedded: ao.Scene) -> None:
    scene = Scene(
        [dataclasses.replace(mesh, color=(1.0, 1.0, 1.0), material=None, vertex_colors=None) for mesh in embedded.meshes]
    )
    camera = embedded.default_camera(SIZE)
    for sky in ({"environment": "white"}, {"environment": "given", "coefficients": (1.0,) * 3 + (0.0,) * 24}):
        picture = any_renderer.render(
            scene, camera, SIZE, settings(**sky, intensity=0.0), aovs=("image", "visibility", "depth"), visibility_bits=8
        )
        seen = picture.depth > 0
        expected = np.round(255 * encode(picture.visibility[seen]))
        assert np.abs(picture.image[seen].astype(int) - expected[:, None]).max() <= 1
        assert picture.visibility[seen].min() < 0.7


def test_what_shines_keeps_energy(any_renderer: ao.Renderer) -> None:
    for metallic in (0.0, 1.0):
        material = Material(metallic=metallic, roughness=0.4)
        scene = Scene([dataclasses.replace(floor(), material=material)])
        picture = any_renderer.render(
            scene, above(), SIZE, settings(environment="white", intensity=0.0, specular=1.0), aovs=("image", "depth")
        )
        light = linear(picture)[picture.depth > 0]
        assert light.size and 0.97 < light.min() <= light.max() <= 1.0


def test_a_highlight_lies_where_a_mirror_shows_the_lamp(any_renderer: ao.Renderer) -> None:
    scene = Scene([dataclasses.replace(floor(), material=Material((0.0, 0.0, 0.0, 1.0), roughness=0.25))])
    camera = Camera.perspective(0.8, 0.1, 60.0, look_at((0, 5, 5), (0, 0, 0)))
    picture = any_renderer.render(scene, camera, SIZE, settings(azimuth=180.0, elevation=45.0, intensity=0.06, specular=1.0))
    y, x = np.unravel_index(picture.image[..., 1].argmax(), picture.image.shape[:2])
    assert abs(x - 63.5) < 4 and abs(y - 47.5) < 4 and 100 < picture.image[..., 1].max() < 255


def test_a_sky_lights_what_looks_up(any_renderer: ao.Renderer) -> None:
    above_only = (0.5, 0.0, 0.0, 0.5, 0.0, 0.0) + (0.0,) * 21  # red from above, fading downwards
    camera = Camera.perspective(0.8, 0.1, 60.0, look_at((0, 0, 8), (0, 0, 0)))
    sky = settings(environment="given", coefficients=above_only, intensity=0.0)
    light = linear(any_renderer.render(white(ball()), camera, SIZE, sky))
    column = light[:, 64, 0][light[:, 64, 1] == 0]
    lit = column[(column > 0)]
    assert lit[2] > 0.65 and lit[-3] < 0.35 and (np.diff(lit) < 0.02).all()


def test_lamps_of_the_scene(any_renderer: ao.Renderer) -> None:
    lamps = [
        Lamp("point", (0.0, 1.0, 0.0), place=(0.0, 1.0, 0.0)),
        Lamp("directional", (2.0, 0.0, 0.0), direction=(0.0, -1.0, 0.0)),
        Lamp("spot", (0.0, 0.0, 1.0), place=(2.0, 1.0, 0.0), direction=(0.0, -1.0, 0.0), cone=(0.2, 0.3)),
    ]
    scene = dataclasses.replace(white(floor()), lamps=lamps)
    camera = Camera.perspective(0.9, 0.1, 60.0, look_at((0, 8, 0), (0, 0, 0), (0, 0, -1)))
    with pytest.raises(ao.SettingsError, match="has no lights of its own"):
        any_renderer.render(white(floor()), camera, SIZE, settings(lamps="scene"))
    light = linear(any_renderer.render(scene, camera, SIZE, settings(lamps="scene", intensity=0.5)))
    floor_seen = light[..., 0] > 0.1
    np.testing.assert_allclose(light[floor_seen][:, 0], 0.5, atol=0.01)  # the brightest is as bright as intensity says
    assert abs(int(light[48, :, 1].argmax()) - 64) <= 1 and light[48, 64, 1] > 4 * light[48, 100, 1]
    blue = np.flatnonzero(light[48, :, 2] > 0.02)
    assert blue.min() > 70 and blue.max() < 100


def test_without_light_there_is_nothing_of_it() -> None:
    plain = plan_render(ao.Settings(method=ao.Bitmask(radius=1.0)), SIZE)
    assert not {"light", "shadow map"} & ({step.task.name for step in plain.steps} | set(plain.culled))
    assert MATERIAL not in {name for step in plain.steps for name in step.task.writes} | set(plain.culled)
    lit = plan_render(settings(environment="white", intensity=1.0, shadows=True), SIZE)
    names = [step.task.name for step in lit.steps]
    assert "shadow map" in names and "composite" not in names and lit.bytes > plain.bytes
    assert "bent_normal" not in lit.where and MATERIAL not in lit.where  # no direction, nothing that shines
    assert "bent_normal" in plan_render(settings(environment="sky"), SIZE).where
    assert not {GAINED, BOUNCE} & set(lit.where) and GAINED in plan_render(settings(indirect="bitmask"), SIZE).where
    assert "shadow map" not in [s.task.name for s in plan_render(settings(shadows=True, intensity=0.0), SIZE).steps]
    assert (
        plan_render(settings(shadows=True), SIZE, ("visibility",)).steps
        == plan_render(ao.Settings(method=ao.Bitmask(radius=0.5)), SIZE, ("visibility",)).steps
    )


def room() -> Scene:
    walls = [
        (quad((0, 0, 0), (0, 0, 1), (1, 0, 0)), (0.9, 0.9, 0.9)),
        (quad((-1, 1, 0), (0, 1, 0), (0, 0, 1)), (0.9, 0.1, 0.1)),
        (quad((0, 1, -1), (1, 0, 0), (0, 1, 0)), (0.9, 0.9, 0.9)),
    ]
    return Scene([dataclasses.replace(mesh, color=color) for mesh, color in walls])


ROOM_CAMERA = Camera.perspective(0.7, 0.1, 20.0, look_at((2.5, 2.2, 3.0), (-0.2, 0.7, -0.2)))


@pytest.mark.parametrize("preset", ["draft", "medium", "high", "ultra"])
def test_the_white_furnace(any_renderer: ao.Renderer, preset: str) -> None:
    scene = white(*room().meshes)
    light = Light(**{**BARE, "environment": "white", "intensity": 0.0, "indirect": "bitmask", "hidden_sky": 0.0})  # type: ignore[arg-type]
    bitmask = ao.Bitmask(radius=0.8, **ao.Bitmask.presets[preset])
    for blur in (ao.Joint(), None):
        settings = ao.Settings(method=bitmask, blur=blur, shading=ao.Shading(background="black"), light=light)
        picture = any_renderer.render(scene, ROOM_CAMERA, SIZE, settings, aovs=("image", "visibility", "depth"), checked=True)
        seen = picture.depth > 0
        assert picture.visibility[seen].min() < 0.7
        assert picture.image[seen].min() >= 254


def test_bounced_light_is_that_of_rays(any_renderer: ao.Renderer) -> None:
    scene, bounced = room(), {"intensity": 1.0, "shadows": True, "azimuth": 50.0, "elevation": 40.0, "indirect": "bitmask"}
    lit = settings(**bounced)
    lit = dataclasses.replace(lit, method=ao.Bitmask(radius=0.8, guard=0.0))
    gained, visibility = (
        any_renderer.resource(scene, ROOM_CAMERA, SIZE, lit, name, aovs=("image",))[::-1]  # type: ignore[index]
        for name in (GAINED, VISIBILITY)
    )
    hidden = 1 - visibility / 255.0
    light = hidden * gained[..., 3:] * gained[..., :3]
    seen = surface(scene, ROOM_CAMERA, SIZE)
    sun = lit_view(lit.light, scene, ROOM_CAMERA, SIZE).eyes["key light"][0].pose[:3, 2]
    truth = one_bounce(seen, sun, 0.8, rays=32)
    assert truth[seen.covered].max() > 0.1
    assert np.sqrt(np.mean((light - truth)[seen.covered] ** 2)) <= 0.02
    hues = [image[seen.covered].sum(0) / image[seen.covered].sum() for image in (light, truth)]
    np.testing.assert_allclose(hues[0], hues[1], rtol=0.1)


def test_colours_bleed_onto_what_stands_beside(any_renderer: ao.Renderer) -> None:
    light = {"environment": "white", "intensity": 0.0}
    plain, tinted, bled = (
        linear(any_renderer.render(room(), ROOM_CAMERA, SIZE, settings(**light, indirect=indirect)))
        for indirect in ("none", "tint", "bitmask")
    )
    grey = np.ptp(plain, axis=-1) < 1e-6
    assert np.ptp(tinted[grey], axis=-1).max() < 1e-6  # as if all around had the surface's own colour
    assert (bled[grey] >= plain[grey] - 1e-6).all() and (tinted[grey] >= plain[grey] - 1e-6).all()
    assert (bled[grey][:, 0] - bled[grey][:, 1]).max() > 0.02


def test_all_of_it_on_every_driver(renderer: ao.Renderer, any_renderer: ao.Renderer) -> None:
    meshes = [dataclasses.replace(mesh, material=Material(roughness=0.3, metallic=0.5)) for mesh in room().meshes[1:]]
    scene = dataclasses.replace(room(), meshes=[room().meshes[0], *meshes])
    light = Light(shadows=True, shadow_side=256, indirect="bitmask", tone="neutral")
    method = ao.Bitmask(radius=0.8, steps=1, slices=1, scale=1, guard=0.0)
    pictures = [
        made.render(
            scene, ROOM_CAMERA, (64, 48), ao.Settings(method=method, blur=None, light=light), checked=True
        ).image.astype(int)
        for made in (renderer, any_renderer)
    ]
    assert np.abs(pictures[0] - pictures[1]).mean() < 1.0 and np.ptp(pictures[0]) > 100


def test_bounces_want_a_method_that_knows_what_hides() -> None:
    with pytest.raises(ao.SettingsError, match="indirect: alchemy does not know what hides a pixel; use the method bitmask"):
        plan_render(ao.Settings(method=ao.Alchemy(radius=1.0), light=Light(indirect="bitmask")), SIZE)
    with pytest.raises(ao.SettingsError, match="indirect: the filter separable is for visibility alone"):
        plan_render(ao.Settings(method=ao.Bitmask(radius=1.0), blur=ao.Separable(), light=Light(indirect="bitmask")), SIZE)
    plan_render(ao.Settings(method=ao.Alchemy(radius=1.0), light=Light(indirect="tint")), SIZE)


def test_tiles_are_lit_like_the_whole(any_renderer: ao.Renderer) -> None:
    lit = ao.Settings(method=ao.Bitmask(radius=0.5, guard=0.0, steps=2), light=Light(shadows=True, shadow_side=256))
    camera = ROOM_CAMERA
    whole = any_renderer.render(room(), camera, SIZE, lit).image
    for x, y in ((0, 0), (64, 48)):
        tile = dataclasses.replace(camera, lens=CropLens(camera.lens, SIZE, (x, y)))
        part = any_renderer.render(room(), tile, (64, 48), lit).image.astype(int)
        expected = whole[48 - y : 96 - y, x : x + 64].astype(int)
        inner = np.abs(part - expected)[16:-16, 16:-16]  # taps beyond a tile's border are the tiles' own affair
        assert np.mean(inner <= 2) > 0.98


def test_arrays_are_not_lit_again() -> None:
    with pytest.raises(ao.SettingsError, match="light: needs a scene"):
        plan_apply(settings(), SIZE)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"color": "#12"}, "light.color='#12'"),
        ({"environment": "given"}, "27 finite numbers"),
        ({"environment": "given", "coefficients": (float("nan"),) * 27}, "27 finite numbers"),
        ({"intensity": -1.0}, "must be 0 to"),
        ({"shadow_side": 4}, "64 to 8192"),
        ({"elevation": 91.0}, "-90 to 90"),
    ],
)
def test_bad_light(fields: dict[str, object], message: str) -> None:
    with pytest.raises(ao.SettingsError, match=message):
        Light(**fields)  # type: ignore[arg-type]
