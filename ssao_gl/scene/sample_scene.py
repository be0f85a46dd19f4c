"""The embedded scene: what ambient occlusion is for. Contact, corners, steps, thin parts, a well, and open sky."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .camera import Camera
from .lens import Perspective
from .model import Mesh, Scene
from .pose import look_at

Arrays = tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.float32]]
WALL, FLOOR = (0.93, 0.91, 0.87), (0.86, 0.87, 0.88)
CLAY, BLUE, GREEN, WOOD = (0.89, 0.62, 0.50), (0.55, 0.68, 0.86), (0.62, 0.76, 0.60), (0.80, 0.70, 0.56)


def default_scene() -> Scene:
    """Return a courtyard corner, 6 units wide, y up, with its camera."""
    ball, post, ring = sphere(), cylinder(24), torus(1.0, 0.28)
    posts = [place((0.07, 0.8, 0.07), (x, 0.8, 1.55)) for x in np.linspace(-2.7, -0.5, 9)]
    steps = [place((0.75, 0.16 * (k + 1), 0.3), (1.95, 0.16 * (k + 1), -0.95 - 0.6 * k)) for k in range(4)]
    draws = [
        _draw(box(), FLOOR, [place((3.2, 0.1, 3.2), (0, -0.1, 0))], "floor"),
        _draw(box(), WALL, [place((3.2, 1.7, 0.1), (0, 1.5, -3.1)), place((0.1, 1.7, 3.0), (-3.1, 1.5, -0.2))], "walls"),
        _draw(box(), WALL, steps, "steps"),
        _draw(box(), CLAY, [place((0.55, 0.55, 0.55), (-1.7, 0.55, -1.6), 0.5)], "box"),
        _draw(
            box(), WOOD, [place((1.2, 0.05, 0.09), (-1.6, 1.65, 1.55)), place((1.2, 0.03, 0.05), (-1.6, 0.85, 1.55))], "rails"
        ),
        _draw(post, WOOD, posts, "posts"),
        _draw(ball, BLUE, [place((0.62,) * 3, (-0.1, 0.62, -1.1)), place((0.3,) * 3, (0.75, 0.3, -0.35))], "balls"),
        _draw(ball, CLAY, [place((0.22,) * 3, (-1.55, 1.32, -1.6))], "small ball"),
        _draw(ring, GREEN, [place((0.6, 0.6, 0.6), (0.95, 0.168, 1.25))], "ring"),
        _draw(well(), WALL, [place((0.55, 0.62, 0.55), (-1.55, 0, 0.2))], "well"),
    ]
    pose = look_at((5.6, 4.3, 6.6), (-0.25, 0.55, -0.35))
    camera = Camera(Perspective(math.radians(32), 1.0, 30.0), pose, "default", 0.7)
    return Scene(draws, cameras=[camera], name="embedded scene")


def _draw(mesh: Arrays, color: tuple[float, float, float], transforms: list[NDArray[np.float64]], name: str) -> Mesh:
    return Mesh(*mesh, color=color, transforms=np.stack(transforms), name=name)


def place(scale: tuple[float, float, float], at: tuple[float, float, float], turn: float = 0.0) -> NDArray[np.float64]:
    """Return a transform (4, 4): scale, turn about y (radians), move."""
    matrix = np.diag([*scale, 1.0])
    c, s = math.cos(turn), math.sin(turn)
    turned = np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]]) @ matrix
    turned[:3, 3] = at
    return turned


def box() -> Arrays:
    """Return the cube -1 .. 1 with flat normals."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)
    parts = []
    for axis in range(3):
        for side in (-1, 1):
            face = np.insert(corners if side > 0 else corners[::-1], axis, side, axis=1)
            parts.append((face, np.broadcast_to(np.eye(3)[axis] * side, (4, 3))))
    positions, normals = (np.concatenate([p[i] for p in parts]).astype(np.float32) for i in range(2))
    quad = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    return positions, np.concatenate([quad + 4 * k for k in range(6)]).astype(np.uint32), normals


def lathe(profile: NDArray[np.float64], normals: NDArray[np.float64], segments: int) -> Arrays:
    """Return a profile (n, 2) of (radius, height) with normals (n, 2), turned about the y axis."""
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]

    def turned(flat: NDArray[np.float64]) -> NDArray[np.float32]:
        r, y = flat[None, :, 0], np.broadcast_to(flat[None, :, 1], (segments + 1, len(flat)))
        return np.stack([c * r, y, s * r], -1).reshape(-1, 3).astype(np.float32)

    n = len(profile)
    i, j = np.meshgrid(np.arange(segments), np.arange(n - 1), indexing="ij")
    a = (i * n + j).ravel()
    triangles = np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)])
    return turned(profile), triangles.astype(np.uint32), turned(normals)


def sphere(segments: int = 64) -> Arrays:
    """Return the unit sphere."""
    t = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    profile = np.stack([np.cos(t), np.sin(t)], 1)
    return lathe(profile, profile, segments)


def cylinder(segments: int = 32) -> Arrays:
    """Return the cylinder of radius 1 from y = -1 to 1, open at its ends."""
    return lathe(np.array([[1.0, -1.0], [1.0, 1.0]]), np.array([[1.0, 0.0], [1.0, 0.0]]), segments)


def torus(major: float, minor: float, segments: int = 64) -> Arrays:
    """Return a ring about the y axis."""
    t = np.linspace(-np.pi, np.pi, segments // 2 + 1)
    normal = np.stack([np.cos(t), np.sin(t)], 1)
    return lathe(normal * minor + [major, 0], normal, segments)


def well(segments: int = 64, inner: float = 0.72) -> Arrays:
    """Return an open tub of outer radius 1 and height 1 with a floor inside."""
    profile = np.array([[1, 0], [1, 1], [1, 1], [inner, 1], [inner, 1], [inner, 0.1], [inner, 0.1], [0, 0.1]], np.float64)
    normals = np.array([[1, 0], [1, 0], [0, 1], [0, 1], [-1, 0], [-1, 0], [0, 1], [0, 1]], np.float64)
    return lathe(profile, normals, segments)
