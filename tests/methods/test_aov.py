"""Ambient occlusion volumes: the form factor against closed forms, what a triangle gives by its falloff, alpha, and what is refused."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import ContextError
from ssao_gl.gl.context import Context
from ssao_gl.gl.executor import FrameExecutor
from ssao_gl.graph.declare import Pass, Texture
from ssao_gl.graph.draws import Fullscreen
from ssao_gl.graph.frame_graph import compile
from ssao_gl.scene.material import ColorTexture, Material
from ssao_gl.scene.model import Mesh, Scene
from ssao_gl.scene.sample_scene import sphere

from ..shapes import QUAD, corner, look_at, quad

SIZE = (64, 48)
DOWN = ao.Camera.orthographic(2.0, 0.0, 20.0, look_at((0, 9, 0), (0, 0, 0), (0, 0, -1)))
"""Sees the floor y = 0 from above: 2 units high."""
FLOOR = quad((0, 0, 0), (20, 0, 0), (0, 0, -20))
HERE = f"{__name__.rpartition('.')[0]}.shaders"


def settings(radius: float = 1.0, **changes: Any) -> ao.Settings:
    given = {"scale": 1, "compensation": "none", "radius": radius} | changes
    return ao.Settings(method=dataclasses.replace(ao.method("aov"), **given), blur=None)


def seen(renderer: ao.Renderer, scene: Scene, camera: ao.Camera = DOWN, **changes: Any) -> np.ndarray:
    return renderer.render(scene, camera, SIZE, settings(**changes), aovs=("visibility",), checked=True).visibility


def beside(renderer: ao.Renderer, things: list[Mesh], **changes: Any) -> float:
    """What things above the middle of the floor take from its left quarter in the mean."""
    return 1 - float(seen(renderer, Scene([FLOOR, *things]), radius=2.0, **changes)[:, :16].mean(dtype=np.float64))


def hidden(renderer: ao.Renderer, corner: tuple[float, ...], right: tuple[float, ...], up: tuple[float, ...]) -> np.ndarray:
    """What ``shaders/form_factor.frag`` draws, in 32-bit floats, by the place of its points along x and z."""
    draw = Fullscreen(f"{HERE}:form_factor.frag", uniforms={"u_corner": corner, "u_right": right, "u_up": up})
    plan = compile([Pass("form factor", "occlusion", draw, {"hidden": Texture("r32f")})], (32, 32), ["hidden"])
    with renderer.ctx.current():
        executor = FrameExecutor(renderer._resources, plan)
        found = executor.run(DOWN.view((32, 32))).read("hidden")[..., 0].T.astype(np.float64)
        executor.release()
    return found


def parallel(x: np.ndarray, z: np.ndarray, height: float) -> np.ndarray:
    """Of a rectangle from straight above the point, (x, z) wide (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3)."""
    a, b = x / height, z / height
    s, t = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
    return (a / s * np.arctan(b / s) + b / t * np.arctan(a / t)) / (2 * math.pi)


def upright(width: np.ndarray, height: float, away: np.ndarray) -> np.ndarray:
    """Of a rectangle that stands on the floor, one of its sides straight ahead of the point (Howell, B-4)."""
    x, y = height / width, away / width
    r = np.sqrt(x * x + y * y)
    return (np.arctan(1 / y) - y / r * np.arctan(1 / r)) / (2 * math.pi)


GRID = np.meshgrid(*[(np.arange(32) + 0.5) / 16 - 1] * 2, indexing="ij")


@pytest.mark.parametrize("height", [0.05, 0.4, 3.0])
def test_a_rectangle_overhead_hides_what_its_closed_form_says(renderer: ao.Renderer, height: float) -> None:
    """Within 1e-4, under it and beside it."""
    found = hidden(renderer, (-0.6, height, -0.8), (1.1, 0, 0), (0, 0, 1.3))
    sides = [(np.array(x - GRID[0]), np.array(z - GRID[1])) for x in (-0.6, 0.5) for z in (-0.8, 0.5)]
    low_low, low_high, high_low, high_high = (parallel(x, z, height) for x, z in sides)
    assert np.abs(found - (high_high - high_low - low_high + low_low)).max() < 1e-4


def test_what_lies_below_the_horizon_hides_nothing(renderer: ao.Renderer) -> None:
    """A wall that goes far down through the floor hides what its part above the floor does, within 1e-4."""
    found = hidden(renderer, (-1.5, -4.0, -1.2), (3.0, 0, 0), (0, 4.7, 0))
    away = GRID[1] + 1.2
    exact = upright(1.5 - GRID[0], 0.7, away) + upright(1.5 + GRID[0], 0.7, away)
    assert np.abs(found - exact).max() < 1e-4
    assert hidden(renderer, (-1.5, -4.0, -1.2), (3.0, 0, 0), (0, 3.9, 0)).max() == 0


@pytest.mark.parametrize("camera", ["parallel", "perspective"])
@pytest.mark.parametrize("power", [0.0, 1.0, 3.0])
def test_a_triangle_gives_its_share_times_its_falloff(renderer: ao.Renderer, power: float, camera: str) -> None:
    """Between two triangles overhead, each at a height below the radius: 1 within its outline, less beside it. The camera looks up from the floor's side."""
    height, radius = 0.5, 1.0
    roof = Mesh(np.float32([[-3, height, -3], [3, height, -3], [0, height, 3]]), np.uint32([[0, 1, 2]]))
    pose = look_at((0, 0.2, 0.4), (0, 0, 0), (0, 0, -1))
    cam = ao.Camera.perspective(0.4, 0.01, 5, pose) if camera == "perspective" else ao.Camera.orthographic(0.1, 0.0, 5.0, pose)
    visibility = seen(renderer, Scene([FLOOR, roof]), cam, radius=radius, power=power)
    depth = renderer.render(Scene([FLOOR, roof]), cam, SIZE, settings(), aovs=("depth",)).depth
    points = cam.view(SIZE).points(depth.astype(np.float64)) @ pose[:3, :3].T + pose[:3, 3]
    exact = share(roof.positions.astype(np.float64), points[24, 32]) * (1 - height / radius) ** power
    assert abs(points[24, 32][1]) < 3e-3 and 1 - visibility[24, 32] == pytest.approx(exact, abs=3e-3)


def share(triangle: np.ndarray, point: np.ndarray) -> float:
    """The form factor of a triangle above the floor, by Lambert's sum over its edges."""
    rays = triangle - point
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(rays, np.roll(rays, -1, 0), strict=True):
        turn = np.cross(a, b)
        total += math.atan2(float(np.linalg.norm(turn)), float(a @ b)) * turn[1] / float(np.linalg.norm(turn))
    return abs(total) / (2 * math.pi)


def test_triangles_that_are_cut_into_four_darken_as_before(renderer: ao.Renderer) -> None:
    """Within .01, where the radius is far larger than they are."""
    a, b, c = np.float32([[-0.1, 0.2, -0.1], [0.1, 0.2, -0.05], [0.0, 0.3, 0.1]])
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    whole = Mesh(np.stack([a, b, c]), np.uint32([[0, 1, 2]]))
    cut = Mesh(np.stack([a, b, c, ab, bc, ca]), np.uint32([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]))
    one, four = (seen(renderer, Scene([FLOOR, mesh]), radius=3.0) for mesh in (whole, cut))
    assert one.min() < 0.95 and np.abs(one - four).max() < 0.01


def test_a_front_darkens_what_lies_before_it_alone(renderer: ao.Renderer) -> None:
    """Also where a transform mirrors it."""
    below = quad((0, 0.5, 0), (0.3, 0, 0), (0, 0, 0.3))  # its front looks down
    above = dataclasses.replace(below, triangles=below.triangles[:, ::-1].copy())
    mirrored = dataclasses.replace(below, transforms=np.diag([-1.0, 1, 1, 1])[None])
    taken = [beside(renderer, [mesh], sides="front") for mesh in (below, above, mirrored)]
    assert taken[0] > 0.005 and taken[1] == 0 and taken[2] == pytest.approx(taken[0], rel=0.02)
    assert beside(renderer, [above], sides="both") == pytest.approx(taken[0], rel=1e-4)


def test_a_lens_that_turns_the_image_over_shows_the_same(any_renderer: ao.Renderer) -> None:
    upright = ao.Camera.perspective(0.9, 0.1, 40.0)
    matrix = upright.lens.matrix(SIZE).copy()
    matrix[1] = -matrix[1]
    one, other = (seen(any_renderer, corner(), cam) for cam in (upright, ao.Camera.from_matrix(matrix)))
    assert one.min() < 0.7 and np.abs(one - other[::-1]).max() < 0.01


def test_half_floats_lose_what_many_triangles_add(any_renderer: ao.Renderer) -> None:
    """A ball of 4096 triangles on the floor: sums in half floats stop to grow, and are off by .15 where it touches the floor."""
    ball = Mesh(*sphere(64), transforms=np.array([[[0.3, 0, 0, 0], [0, 0.3, 0, 0.3], [0, 0, 0.3, 0], [0, 0, 0, 1.0]]]))
    whole, half = (seen(any_renderer, Scene([FLOOR, ball]), sums=sums) for sums in ("float", "half"))
    assert (half >= whole - 1e-3).all() and 0.01 < np.abs(whole - half).max() < 0.2


@pytest.mark.parametrize(("left", "expected"), [(0, 0.0), (8, 0.5), (16, 1.0)])
def test_what_alpha_cuts_out_hides_nothing(renderer: ao.Renderer, left: int, expected: float) -> None:
    picture = np.full((16, 16, 4), 255, np.uint8)
    picture[:, left:, 3] = 0
    material = Material(alpha_mode="MASK", base_color_texture=ColorTexture(picture, nearest=True))
    uv = np.float32([[0, 0], [1, 0], [1, 1], [0, 1]])
    roof = quad((0, 0.5, 0), (0.3, 0, 0), (0, 0, 0.3))
    solid, cut = (beside(renderer, [mesh]) for mesh in (roof, dataclasses.replace(roof, material=material, uv=uv)))
    assert solid > 0.005 and cut / solid == pytest.approx(expected, abs=0.1)


def test_compensation_bounds_what_overlaps(any_renderer: ao.Renderer) -> None:
    """Sums beyond 1 stay visible to a degree: exp(-sum)."""
    roofs = [quad((0, 0.2 + 0.1 * k, 0), (2, 0, 0), (0, 0, 2)) for k in range(3)]
    pose = look_at((0, 0.05, 1), (0, 0, 0), (0, 1, 0))
    low = ao.Camera.perspective(0.1, 0.01, 9, pose)
    none, exp = (seen(any_renderer, Scene([FLOOR, *roofs]), low, compensation=kind)[24, 32] for kind in ("none", "exp"))
    assert none == 0 and 0.05 < exp < math.exp(-1)


def test_a_fill_of_minutes_is_refused_with_figures(any_renderer: ao.Renderer) -> None:
    with pytest.raises(
        ao.SettingsError,
        match=r"aov: 4 triangles would fill about \d+ million fragments in 64x48 texels.*scale=4, a radius below 1",
    ):
        seen(any_renderer, corner(), ao.Camera.perspective(0.9, 0.1, 40), max_fill=1e-3)


def test_spheres_hide_nothing_and_that_is_said(any_renderer: ao.Renderer) -> None:
    ball = ao.Spheres.from_points([(0, 0.3, 0)], 0.2)
    with pytest.warns(ao.InputWarning, match="aov: knows triangles alone; spheres and volumes hide nothing here"):
        assert seen(any_renderer, Scene([FLOOR], spheres=[ball]))[:, :16].min() == 1


def test_depth_buffers_are_refused(any_renderer: ao.Renderer) -> None:
    with pytest.raises(ao.SettingsError, match="aov: needs a scene"):
        any_renderer.apply(np.ones((8, 8), np.float32), DOWN, settings=settings())


def test_a_driver_that_adds_up_no_floats_is_told_what_to_use(
    any_renderer: ao.Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Context, "blends_floats", property(lambda self: False))
    scene = Scene([FLOOR, Mesh(np.float32([[0, 0.1, 0], [1, 0.1, 0], [0, 0.1, 1]]), QUAD[:1])])
    with pytest.raises(ContextError, match=r"does not add up 32-bit floats; use half floats \(the method's sums=half\)"):
        seen(any_renderer, scene)
    assert seen(any_renderer, scene, sums="half").min() < 0.99
