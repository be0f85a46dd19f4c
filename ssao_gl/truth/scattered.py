"""Rays from the pixels of a G-buffer, at any share of a ray a pixel: for pictures that a few rays correct."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import HostWork
from ..graph.regions import Rect
from ..sampling.falloff import Falloff, rho
from ..sampling.hemisphere import frames
from ..sampling.scatter import RayLayer, ray_layers
from ..scene.camera import Camera
from ..scene.projection import Size, ViewConstants
from .batches import local_radius
from .blockers import DIAMETER, OFFSET, threads
from .rays import RayScene
from .settings import Tracing
from .sums import blocks

F32 = NDArray[np.float32]

PIXEL_SHARE = 0.25
"""Pixels by which rays start above what the G-buffer shows: depth of grazing planes is off by as much as 0.16 (SwiftShader; Mesa: 0.00003)."""
DEPTH_ROUNDING = 2.0**-20
"""The same for the rounding of depth, as a share of it."""
RAYS_TOGETHER = 1 << 14
"""Traced in one piece."""


@dataclass(frozen=True, eq=False)
class ScatteredRays:
    """Does the work ``rays`` of a plan. ``corner``: pixel of the picture, ``whole`` pixels large, at the lower left of the frame."""

    scene: RayScene
    camera: Camera
    corner: tuple[int, int]
    whole: Size

    def __call__(self, work: HostWork, view: ViewConstants, rect: Rect, arrays: Sequence[F32]) -> F32:
        """Return (h, w), row 0 at the bottom: the number of rays of a pixel plus half of the share that met nothing; 0 without rays.

        ``arrays``: linear depth (h, w, 1) and encoded normals (h, w, 2) of ``rect``. values: share (rays a pixel), radius (scene
        units), falloff. Raises SettingsError for a radius that 32-bit rays cannot tell from none.
        """
        share, radius, falloff = (work.values[name] for name in ("share", "radius", "falloff"))
        reach = local_radius(self.scene, Tracing(radius=float(radius)))
        depth, normals = arrays[0][..., 0].reshape(-1), arrays[1].reshape(-1, 2)  # views: their steps merge
        starts = _Starts.of(self.scene, self.camera, view, rect, depth, normals)
        counts, blocked = np.zeros(len(depth), np.float32), np.zeros(len(depth), np.float32)
        corner = self.corner[0] + rect[0], self.corner[1] + rect[1]
        with ThreadPoolExecutor(threads()) as pool:
            for layer in ray_layers(corner, (rect[2], rect[3]), self.whole, float(share)):
                trace = _LayerTrace(starts, layer, reach, Falloff(str(falloff)), counts, blocked)
                list(pool.map(trace.part, blocks(len(layer.pixel), RAYS_TOGETHER)))
        traced, out = np.flatnonzero(counts > 0), np.zeros(len(depth), np.float32)
        number = counts[traced]
        out[traced] = number + np.float32(0.5) * (1 - blocked[traced] / number)
        return out.reshape(rect[3], rect[2])


@dataclass(frozen=True, eq=False)
class _Starts:
    """Where rays start: points and normals of pixels in local coordinates, by matrices upon (x, y, 1) of a pixel of the part."""

    scene: RayScene
    width: int
    """Of the part, pixels."""
    depth: F32
    normals: F32
    along: F32
    """(3, 3): what a unit of depth adds to a point."""
    still: F32
    """(3, 3): the point at depth 0."""
    turn: F32
    """(3, 3): view space to local axes."""
    above: tuple[float, float]
    """Distance from the surface at depth 0, and what a unit of depth adds to it."""

    @classmethod
    def of(cls, scene: RayScene, camera: Camera, view: ViewConstants, rect: Rect, depth: F32, normals: F32) -> _Starts:
        c, (w, h), pose, scale = view.constants, view.size, camera.pose, scene.scale
        uv = np.array([[1 / w, 0, (rect[0] + 0.5) / w], [0, 1 / h, (rect[1] + 0.5) / h], [0, 0, 1]])
        ray, org = np.zeros((3, 3)), np.zeros((3, 3))
        for matrix, name in ((ray, "u_ray"), (org, "u_org")):
            matrix[:2, :2], matrix[:2, 2] = np.reshape(c[name], (2, 2)).T, c[f"{name}0"]
        ray[2, 2] = -1
        eye = scale * pose[:3, :3] @ org
        eye[:, 2] += scale * (pose[:3, 3] - scene.center)
        turn = np.linalg.inv(pose[:3, :3]).T
        above = (
            OFFSET + scale * PIXEL_SHARE * view.pixel * view.w0,
            scale * (PIXEL_SHARE * view.pixel * view.w1 + DEPTH_ROUNDING),
        )
        along, still, turn = (np.asarray(m, np.float32) for m in (scale * pose[:3, :3] @ ray @ uv, eye @ uv, turn))
        return cls(scene, rect[2], depth, normals, along, still, turn, above)

    def at(self, pixel: NDArray[np.int32]) -> tuple[F32, F32]:
        """Return starts and unit normals (3, n) of pixels, counted row by row."""
        y, x = np.divmod(pixel, np.int32(self.width))
        place = np.stack([x, y, np.ones_like(x)]).astype(np.float32)
        z, encoded = self.depth[pixel], self.normals[pixel].T
        f = np.minimum(encoded[0] ** 2 + encoded[1] ** 2, 4)
        normal = self.turn @ np.stack([*(encoded * np.sqrt(1 - f / 4)), 1 - f / 2])  # as lib/normal.glsl decodes it
        normal /= np.sqrt((normal**2).sum(0))
        above = np.float32(self.above[0]) + np.float32(self.above[1]) * z
        return self.along @ place * z + self.still @ place + above * normal, normal


@dataclass(frozen=True, eq=False)
class _LayerTrace:
    """The rays of one layer. radius: in local units. counts, blocked: (h * w,) float32, rays of each pixel, and what they count as occlusion."""

    starts: _Starts
    layer: RayLayer
    radius: float
    falloff: Falloff
    counts: F32
    blocked: F32

    def part(self, at: slice) -> None:
        """Trace some rays, none of background. A layer has no pixel twice, so that parts may run at once."""
        pixel, sample = self.layer.pixel[at], self.layer.direction[:, at]
        seen = self.starts.depth[pixel] > 0
        if not seen.all():
            pixel, sample = pixel[seen], sample[:, seen]
        origins, normals = self.starts.at(pixel)
        tangent, bitangent = frames(normals)
        directions = tangent * sample[0] + bitangent * sample[1] + normals * sample[2]
        self.counts[pixel] += 1
        self.blocked[pixel] += self._occlusion(np.ascontiguousarray(origins.T), np.ascontiguousarray(directions.T))

    def _occlusion(self, origins: F32, directions: F32) -> F32:
        """Return what each ray (n, 3) counts, in 0..1."""
        reach = np.float32(min(self.radius, DIAMETER))
        scene = self.starts.scene
        if self.falloff == Falloff.HARD:
            return scene.occluded(origins, directions, float(reach)).astype(np.float32)
        far = scene.distances(origins, directions, float(reach))
        return np.where(far < reach, rho(self.falloff, far / np.float32(self.radius)), 0).astype(np.float32)
