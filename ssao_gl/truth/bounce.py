"""Light of a directional lamp that reaches a picture by one bounce, by rays."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError
from ..sampling.hemisphere import hemisphere_directions, sobol_points
from ..scene.srgb import decode
from .blockers import DIAMETER, F32, F64, OFFSET, threads
from .rays import RayScene
from .sums import blocks
from .surface import Surface

PIXELS_TOGETHER = 1 << 14


def one_bounce(seen: Surface, to_light: ArrayLike, radius: float, *, rays: int = 64, seed: int = 0) -> NDArray[np.float32]:
    """Return what is reflected to each pixel from within ``radius`` (scene units) of it, (h, w, 3), row 0 on top.

    The lamp in the direction to_light, (3,) unit, world, brings 1 to what faces it. What comes back is irradiance over pi: the mean
    over cosine-weighted directions of base colour times what arrives where they end. Raises SceneError for scenes with textures or
    vertex colours.
    """
    albedo = _albedo(seen.rays)
    to = np.asarray(to_light, np.float64)
    out = np.zeros((len(seen.origins), 3), np.float32)
    samples = sobol_points(rays, seed, 0)

    def part(at: slice) -> None:
        random = np.random.default_rng([seed, at.start])
        for directions in hemisphere_directions(seen.normals[at], samples, random):
            out[at] += _reflected(seen.rays, seen.origins[at], directions, radius * seen.rays.scale, to, albedo)

    with ThreadPoolExecutor(threads()) as pool:
        list(pool.map(part, blocks(len(out), PIXELS_TOGETHER)))
    return np.stack([seen.image(channel / rays, 0) for channel in out.T], -1)


def _reflected(rays: RayScene, origins: NDArray[np.float32], directions: F32, reach: float, to: F64, albedo: F64) -> F64:
    """Return the light (n, 3) that comes back along each ray."""
    ends = np.full(len(origins), reach, np.float32)
    towards = np.ascontiguousarray(directions)
    hits = rays.triangles.hits(origins, towards, ends)
    parts = rays.triangles.parts_hit(origins, towards, ends)[hits.rays]
    normals = hits.normals / np.maximum(np.linalg.norm(hits.normals, axis=1, keepdims=True), 1e-300)
    normals *= -np.sign((normals * directions[hits.rays]).sum(1, keepdims=True))
    cosine = normals @ to
    lit = np.flatnonzero(cosine > 0)
    starts = (hits.points[lit] + OFFSET * normals[lit]).astype(np.float32)
    free = ~(rays.occluded(starts, np.broadcast_to(to.astype(np.float32), starts.shape), DIAMETER) > 0.5)
    out = np.zeros((len(origins), 3))
    out[hits.rays[lit]] = albedo[parts[lit]] * (cosine[lit] * free)[:, None]
    return out


def _albedo(rays: RayScene) -> F64:
    """Return the linear base colour (n, 3) of each part. Raises SceneError."""
    meshes = [mesh for mesh in rays.scene.drawn for _ in mesh.transforms]
    if any(getattr(mesh, "texture", None) is not None or getattr(mesh, "vertex_colors", None) is not None for mesh in meshes):
        raise SceneError(
            f"{rays.scene.name or 'the scene'}: bounces are traced off surfaces of one colour each; this one has others"
        )
    return np.array([decode(mesh.color) for mesh in meshes])
