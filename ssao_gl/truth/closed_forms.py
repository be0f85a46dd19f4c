"""Little scenes whose ambient occlusion is known on paper: tests of rays, and of screen-space methods, without rays.

Occlusion here is the form factor of the blockers: the cosine-weighted share of the hemisphere that they fill. Formulas:
Howell, "A Catalog of Radiation Heat Transfer Configuration Factors"; the wall under a hard radius is the cap that the
wall's plane cuts from the hemisphere of that radius, projected to the floor (Nusselt's analog). All lengths are scene
units, y is up and floors lie at y = 0. Meshes follow their curves within 1e-4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..scene.camera import Camera
from ..scene.lens import Perspective
from ..scene.model import Mesh, Scene
from ..scene.pose import look_at
from ..scene.projection import Size
from ..scene.sample_scene import cylinder, lathe, place, sphere

F64 = NDArray[np.float64]

SEGMENTS = 256
NEAR = 1e-3
"""Points this close to a surface are taken to lie on it."""


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A scene, a camera that sees the points it is about, and what a hard ``radius`` gives there.

    visibility: from world points (n, 3) on what the camera sees to (n,) in 0..1, nan where it is not known. flat: whether
    the blockers are walls that the camera sees from all over, so that one layer of depth can be right.
    """

    name: str
    formula: str
    scene: Scene
    camera: Camera
    radius: float
    visibility: Callable[[F64], F64]
    flat: bool
    size: Size = (64, 48)


@cache
def closed_forms() -> Mapping[str, ClosedForm]:
    """All of them by name."""
    makers = (plane_scene, wall, ball_scene, raised_ball, disk, well_bottom, trench, bowl, post)
    return {form.name: form for form in (make() for make in makers)}


def plane_scene() -> ClosedForm:
    """Return an unbounded floor."""
    camera = _camera((0, 2, 3), (0, 0, 0))
    return ClosedForm("plane", "O = 0", Scene([_floor()]), camera, 1.0, lambda p: np.ones(len(p)), True)


def wall() -> ClosedForm:
    """Floor and wall at right angles, both unbounded, within a radius of 1; each blocks the other."""
    radius = 1.0

    def visibility(points: F64) -> F64:
        k = np.minimum(points[:, :2].max(1) / radius, 1).clip(0)  # the distance from the other of the two
        return np.asarray(1 - (np.arccos(k) - k * np.sqrt(1 - k**2)) / np.pi)

    scene = Scene([_floor((25, 0, 0), (25, 0, 0)), _quad((0, 2, 0), (0, 0, 50), (0, 2, 0), "wall")])
    camera = _camera((3.2, 2.6, 0.4), (0.5, 0.2, 0))
    return ClosedForm(
        "wall", "O = (acos k - k sqrt(1 - k^2)) / pi, k = distance / radius", scene, camera, radius, visibility, True
    )


def ball_scene() -> ClosedForm:
    """Return a ball of radius 1 that lies on the floor."""
    return _ball("ball", 1.0, "O = r^3 / (s^2 + r^2)^(3/2), s = way from the point of contact")


def raised_ball() -> ClosedForm:
    """Return a ball of radius 1 with its centre at height 2."""
    return _ball("raised_ball", 2.0, "O = r^2 h / (s^2 + h^2)^(3/2), h = height of the centre")


def disk() -> ClosedForm:
    """Return a disk of radius 1, 1.2 above the floor and parallel to it."""
    height = 1.2
    thin = lathe(np.array([[0.0, height], [1.0, height]]), np.array([[0.0, 1.0], [0.0, 1.0]]), SEGMENTS)
    formula = "O = 1/2 - (h^2 + s^2 - r^2) / (2 sqrt((h^2 + s^2 + r^2)^2 - 4 s^2 r^2)), s = way from the axis"
    scene = Scene([_floor(), Mesh(*thin, name="disk")])
    camera = _camera((0, 0.9, 3.2), (0, 0, 0.2))
    return ClosedForm("disk", formula, scene, camera, 10.0, _on_floor(lambda p: 1 - disk_factor(p, 1.0, height)), False)


def well_bottom() -> ClosedForm:
    """Return the bottom of a round well of radius 1 and depth 1.5: the sky is a disk above it."""
    depth = 1.5
    profile = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, depth]])
    inner = lathe(profile, np.array([[0.0, 1.0], [0.0, 1.0], [-1.0, 0.0], [-1.0, 0.0]]), SEGMENTS)
    formula = "A = 1/2 - (h^2 + s^2 - r^2) / (2 sqrt((h^2 + s^2 + r^2)^2 - 4 s^2 r^2)), s = way from the axis"
    camera = _camera((0.05, 4.5, 0.1), (0, 0, 0), up=(0, 0, -1))
    scene = Scene([Mesh(*inner, name="well")])

    def open_sky(points: F64) -> F64:
        inside = np.hypot(points[:, 0], points[:, 2]) < 1 - NEAR
        return np.where(inside, disk_factor(points, 1.0, depth), np.nan)

    return ClosedForm("well", formula, scene, camera, 10.0, _on_floor(open_sky), True)


def trench() -> ClosedForm:
    """Return the bottom of a long trench of half width 1 and depth 1.5."""
    depth, half = 1.5, 1.0

    def open_sky(points: F64) -> F64:
        left, right = half + points[:, 0], half - points[:, 0]
        sky = 0.5 * (left / np.hypot(left, depth) + right / np.hypot(right, depth))
        return np.where(np.minimum(left, right) > NEAR, sky, np.nan)

    sides = [_quad((x, depth / 2, 0), (0, 0, 40), (0, depth / 2, 0), "side") for x in (-half, half)]
    scene = Scene([_quad((0, 0, 0), (half, 0, 0), (0, 0, 40), "floor"), *sides])
    formula = "A = (b + x) / (2 sqrt((b + x)^2 + h^2)) + (b - x) / (2 sqrt((b - x)^2 + h^2)), x = way from the middle"
    camera = _camera((0.1, 4.5, 0.2), (0, 0, 0), up=(0, 0, -1))
    return ClosedForm("trench", formula, scene, camera, 40.0, _on_floor(open_sky), True)


def bowl() -> ClosedForm:
    """Return the inside of a hemisphere of radius 1: seen from everywhere on it, its other half fills half of what there is."""
    segments = 2 * SEGMENTS  # here the tilt of the facets counts, which falls with the first power only
    turn = np.linspace(-np.pi / 2, 0, segments // 4 + 1)
    profile = np.stack([np.cos(turn), np.sin(turn)], 1)
    scene = Scene([Mesh(*lathe(profile, -profile, segments), name="bowl")])
    camera = _camera((0.1, 3.2, 0.2), (0, -0.4, 0), up=(0, 0, -1))
    return ClosedForm("bowl", "O = 1/2", scene, camera, 10.0, lambda p: np.full(len(p), 0.5), True)


def post() -> ClosedForm:
    """Return a round post of radius 0.25 that stands on the floor and does not end."""
    radius = 0.25

    def visibility(points: F64) -> F64:
        return 1 - np.arcsin(np.minimum(radius / np.hypot(points[:, 0], points[:, 2]), 1)) / np.pi

    shaft = Mesh(*cylinder(SEGMENTS), transforms=place((radius, 30, radius), (0, 30, 0))[None], name="post")
    camera = _camera((1.5, 2.2, 2.8), (0, 0, 0.6))
    formula = "O = asin(r / D) / pi, D = way from the axis"
    return ClosedForm("post", formula, Scene([_floor(), shaft]), camera, 60.0, _on_floor(visibility), False)


def disk_factor(points: ArrayLike, radius: float, height: float) -> F64:
    """Form factor (n,) from floor points (n, 3) to a disk about the y axis at ``height``, parallel to the floor."""
    x, _, z = np.asarray(points, np.float64).T
    way, h, r = x**2 + z**2, height**2, radius**2
    return np.asarray(0.5 - 0.5 * (h + way - r) / np.sqrt((h + way + r) ** 2 - 4 * way * r))


def _ball(name: str, height: float, formula: str) -> ClosedForm:
    def visibility(points: F64) -> F64:
        return 1 - height / (points[:, 0] ** 2 + points[:, 2] ** 2 + height**2) ** 1.5

    round_ = Mesh(*sphere(SEGMENTS), transforms=place((1, 1, 1), (0, height, 0))[None], name="ball")
    camera = _camera((0, 1.6 * height, 6.5), (0, 0, 1))
    return ClosedForm(name, formula, Scene([_floor(), round_]), camera, 20.0, _on_floor(visibility), False)


def _on_floor(visibility: Callable[[F64], F64]) -> Callable[[F64], F64]:
    """nan for points that do not lie on the floor."""
    return lambda points: np.where(np.abs(points[:, 1]) < NEAR, visibility(points), np.nan)


def _floor(center: tuple[float, float, float] = (0, 0, 0), x: tuple[float, float, float] = (50, 0, 0)) -> Mesh:
    return _quad(center, x, (0, 0, 50), "floor")


def _quad(center: ArrayLike, right: ArrayLike, up: ArrayLike, name: str) -> Mesh:
    """Return a parallelogram about ``center``, from its middle to its sides by ``right`` and ``up``."""
    c, r, u = (np.asarray(v, np.float32) for v in (center, right, up))
    corners = np.stack([c - r - u, c + r - u, c + r + u, c - r + u])
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), name=name)


def _camera(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0, 1, 0)) -> Camera:
    return Camera(Perspective(math.radians(40), 0.1, 100.0), look_at(eye, target, up))
