"""The space around each triangle that it may darken: the triangles of a scene at their places, and how much drawing them fills."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .camera import Camera
from .model import Mesh, Scene
from .projection import Size, ViewConstants
from .texels import alpha_at

F64 = NDArray[np.float64]

CHUNK = 1 << 16
"""Triangles looked at at a time."""
LOOKED_AT = 1 << 15
"""Triangles that an estimate is made of, about, in large scenes; and of each mesh at least ``FEW``."""
FEW = 64
PARTS = 4
"""Along each side of a triangle, for which alpha is looked up."""
FACES = np.array([[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]])
"""Corners of each face of a box, counter-clockwise from outside; bits of a corner's number: up, across, along."""


def placed_triangles(scene: Scene, every: int = 1) -> Iterator[tuple[F64, F64, int]]:
    """Yield the triangles (n, 3, 3) of all meshes that may be seen, every instance, about the middle of the scene's bounds, the
    share (n,) of each that alpha leaves, and for how many each stands: ``every`` one, fewer in small meshes.

    Those without an area, and those of which nothing is left, are left out.
    """
    middle = scene.bounds.mean(0)
    for mesh in (thing for thing in scene.drawn if isinstance(thing, Mesh)):
        step = max(1, min(every, len(mesh.triangles) // FEW))
        for start in range(0, len(mesh.triangles), CHUNK * step):
            some = np.arange(start, min(start + CHUNK * step, len(mesh.triangles)), step)
            local, solid = mesh.positions[mesh.triangles[some]].astype(np.float64), _solid(mesh, some)
            for matrix in mesh.transforms:
                corners = local @ matrix[:3, :3].T + (matrix[:3, 3] - middle)
                if np.linalg.det(matrix[:3, :3]) < 0:
                    corners = corners[:, ::-1]
                kept = (solid > 0) & np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).any(1)
                yield corners[kept], solid[kept], step


def _solid(mesh: Mesh, triangles: NDArray[np.integer]) -> F64:
    """Return the share (n,) of triangles that alpha leaves, in the middles of their ``PARTS`` x ``PARTS`` equal parts."""
    cutoff = mesh.cutoff
    if cutoff is None:
        return np.ones(len(triangles))
    upright = [(i + 1 / 3, j + 1 / 3) for i in range(PARTS) for j in range(PARTS - i)]
    turned = [(i + 2 / 3, j + 2 / 3) for i in range(PARTS - 1) for j in range(PARTS - 1 - i)]
    places = np.array([*upright, *turned]) / PARTS
    whole = np.ones(len(triangles))
    return np.asarray(np.mean([alpha_at(mesh, triangles, u * whole, v * whole) >= cutoff for u, v in places], axis=0))


def prism_fill(scene: Scene, camera: Camera, view: ViewConstants, size: Size, radius: float, *, both_sides: bool) -> float:
    """Return how many fragments the boxes around all triangles fill in a target of ``size`` texels, about.

    A box is counted by the area of its outline, as much of it as its bounds have in the image; one that reaches behind the
    eye as the whole image.
    """
    from_middle = np.linalg.inv(camera.pose)
    from_middle[:3, 3] += from_middle[:3, :3] @ scene.bounds.mean(0)
    total = 0.0
    for corners, _, each in placed_triangles(scene, max(1, scene.triangles // LOOKED_AT)):
        if not len(corners):
            continue
        seen = corners @ from_middle[:3, :3].T + from_middle[:3, 3]
        texel = texel_reach(radius - seen[..., 2].min(1), view, size)
        boxes = _boxes(seen, radius + texel, -(radius + texel) if both_sides else -texel)
        total += each * float(shares(boxes, view).sum())
    return total * size[0] * size[1]


def texel_reach(farthest: F64, view: ViewConstants, size: Size) -> F64:
    """Return how wide a texel of a target of ``size`` is at linear depths (n,)."""
    pixels = max(view.size[0] / size[0], view.size[1] / size[1])
    return np.asarray(view.pixel * pixels * np.abs(view.w1 * farthest + view.w0))


def _boxes(triangles: F64, reach: F64, below: F64) -> F64:
    """Return the corners (n, 8, 3) of the boxes that ``prisms.vert`` draws around triangles (n, 3, 3): ``reach`` (n,) to all sides
    but down, where they begin at ``below`` (n,)."""
    edges = np.roll(triangles, -1, 1) - triangles
    longest = (edges**2).sum(2).argmax(1)
    along = _unit(edges[np.arange(len(edges)), longest])
    up = _unit(np.cross(edges[:, 0], -edges[:, 2]))
    across = np.cross(up, along)
    away = triangles - triangles[:, :1]
    sides = np.stack([along, across, up], 1)
    places = np.einsum("nij,nkj->nki", sides[:, :2], away)
    low = np.concatenate([places.min(1) - reach[:, None], below[:, None]], 1)
    high = np.concatenate([places.max(1) + reach[:, None], reach[:, None]], 1)
    bits = np.array([[corner & 4, corner & 2, corner & 1] for corner in range(8)]) > 0
    chosen = np.where(bits, high[:, None], low[:, None])
    return np.asarray(triangles[:, :1] + np.einsum("nki,nij->nkj", chosen, sides))


def shares(boxes: F64, view: ViewConstants) -> F64:
    """Return the share of the image (n,) that each box (n, 8, 3) in view space covers."""
    m = view.projection
    clip = boxes @ m[:, :3].T + m[:, 3]
    behind = (clip[..., 3] <= 1e-6 * np.abs(clip).max((1, 2))[:, None]).sum(1)
    with np.errstate(all="ignore"):
        ndc = clip[..., :2] / clip[..., 3:]
        low, high = ndc.min(1), ndc.max(1)
        inside = np.clip(np.minimum(high, 1) - np.maximum(low, -1), 0, None) / (high - low)
        across = ndc[:, FACES[:, 2]] - ndc[:, FACES[:, 0]], ndc[:, FACES[:, 3]] - ndc[:, FACES[:, 1]]
        faces = (across[0][..., 0] * across[1][..., 1] - across[0][..., 1] * across[1][..., 0]) / 2
        outline = np.abs(faces).sum(1) / 2
        seen = outline * inside.prod(1) / 4
    return np.where(behind == 8, 0.0, np.where(behind > 0, 1.0, np.minimum(np.nan_to_num(seen), 1.0)))


def _unit(vectors: F64) -> F64:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
