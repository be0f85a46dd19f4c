"""What a camera sees: the point and the normal behind every pixel centre, from primary rays."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size, ViewConstants
from .blockers import DIAMETER, F32, F64, OFFSET, threads
from .rays import RayScene
from .sums import blocks

CHUNK = 1 << 14
"""Pixels a step."""


@dataclass(frozen=True, eq=False)
class PixelPlaces:
    """Points that rays start from, each a place by itself."""

    rays: RayScene
    origins: F32
    normals: F32

    def __len__(self) -> int:
        return len(self.origins)

    def points(self, at: slice) -> list[tuple[F32, F32]]:
        return [(self.origins[at], self.normals[at])]


@dataclass(frozen=True, eq=False)
class Surface:
    """The visible surface, of covered pixels only, in row order (row 0 on top).

    depth: (h, w) float32, distance along the view axis in scene units, 0 = background. origins: (n, 3) float32, where
    rays start, local units of ``rays``, just off the surface. normals: (n, 3) float32, unit, world axes, of the triangle
    and on the viewer's side. shading: the same of the interpolated vertex normals, the triangle's own where there are none.
    """

    rays: RayScene
    depth: F32
    origins: F32
    normals: F32
    shading: F32

    def places(self, normals: str = "geometric") -> PixelPlaces:
        """Return where rays start, one point a covered pixel, about normals of a kind: geometric or shading."""
        return PixelPlaces(self.rays, self.origins, self.shading if normals == "shading" else self.normals)

    @property
    def covered(self) -> NDArray[np.bool_]:
        """(h, w), where the camera sees the scene."""
        return self.depth > 0

    def points(self) -> F64:
        """World positions (n, 3) of the surface, within the offset of 2^-20 of half the scene's size."""
        return (self.origins.astype(np.float64) - OFFSET * self.normals) / self.rays.scale + self.rays.center

    def image(self, values: NDArray[np.floating], background: float) -> F32:
        """Values (n,) of the covered pixels as an image (h, w) float32."""
        out = np.full(self.depth.shape, background, np.float32)
        out[self.covered] = values
        return out


def surface(scene: Scene | RayScene, camera: Camera, size: Size) -> Surface:
    """Trace a primary ray through every pixel centre. ``size`` is (width, height). Raises SettingsError, SceneError.

    Any projection that :class:`~ssao_gl.scene.projection.ViewConstants` takes; what lies before its near or behind its far plane is not seen.
    """
    rays = scene if isinstance(scene, RayScene) else RayScene(scene)
    view, count = camera.view(size), size[0] * size[1]
    depth = np.zeros(count, np.float32)
    with ThreadPoolExecutor(threads()) as pool:
        kept = list(pool.map(lambda part: _hit(rays, camera, view, part, depth), blocks(count, CHUNK)))
    origins, normals, shading = (np.concatenate([k[i] for k in kept]) for i in range(3))
    return Surface(rays, depth.reshape(size[1], size[0]), origins, normals, shading)


def _pixel_rays(view: ViewConstants, part: slice) -> tuple[F64, F64]:
    """View-space starts and directions (n, 3) of some pixels, counted from the top left: point = start + depth * direction."""
    index = np.arange(part.start, part.stop)
    w, h = view.size
    uv = np.stack([(index % w + 0.5) / w, 1 - (index // w + 0.5) / h], -1)
    c = view.constants
    direction = uv @ np.reshape(c["u_ray"], (2, 2)) + np.asarray(c["u_ray0"])
    start = uv @ np.reshape(c["u_org"], (2, 2)) + np.asarray(c["u_org0"])
    ones = np.ones((len(index), 1))
    return np.concatenate([start, 0 * ones], 1), np.concatenate([direction, -ones], 1)


def _hit(rays: RayScene, camera: Camera, view: ViewConstants, part: slice, depth: F32) -> tuple[F32, F32, F32]:
    """Origins, normals and shading normals of the covered pixels among ``part``; their depth goes into ``depth[part]``."""
    start, direction = _pixel_rays(view, part)
    start = (start @ camera.pose[:3, :3].T + camera.pose[:3, 3] - rays.center) * rays.scale
    direction = direction @ camera.pose[:3, :3].T
    # Rays start where they enter the scene's sphere: an eye far away costs no precision.
    length = np.linalg.norm(direction, axis=1)
    middle = -(start * direction).sum(1) / length**2
    near = np.maximum(view.near * rays.scale, middle - DIAMETER / 2 / length)
    far = np.minimum(view.far * rays.scale, middle + DIAMETER / 2 / length)
    met = np.flatnonzero(far > near)
    start, direction, near, far = start[met], direction[met], near[met], far[met]
    found = rays.hits(
        (start + near[:, None] * direction).astype(np.float32), direction.astype(np.float32), (far - near).astype(np.float32)
    )
    hit, points, normals, shading = found.rays, found.points, found.normals, found.shading
    direction = direction[hit]
    normals = _unit(normals, -direction)
    normals *= _side(normals, -direction)
    shading = _unit(shading, normals)
    shading *= _side(shading, normals)
    # Along the view axis, to the point itself.
    axis = -camera.pose[:3, 2]
    eye = (camera.pose[:3, 3] - rays.center) * rays.scale
    depth[part.start + met[hit]] = np.maximum((points - eye) @ axis / (axis @ axis) / rays.scale, np.finfo(np.float32).tiny)
    origins = points + OFFSET * normals
    return origins.astype(np.float32), normals.astype(np.float32), shading.astype(np.float32)


def _unit(vectors: F64, instead: F64) -> F64:
    """Return unit vectors (n, 3); those of no or infinite length are replaced."""
    with np.errstate(invalid="ignore", over="ignore"):
        largest = np.abs(vectors).max(1, keepdims=True, initial=0)
        good = np.isfinite(largest) & (largest > 0)
        vectors = np.where(good, vectors / np.where(good, largest, 1), instead)
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _side(vectors: F64, towards: F64) -> F64:
    return np.where((vectors * towards).sum(1, keepdims=True) < 0, -1.0, 1.0)
