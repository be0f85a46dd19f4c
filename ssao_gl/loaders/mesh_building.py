"""Meshes from the arrays of a file: checked, centred, without vertices that nothing names, with normals where there are none."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.baked_visibility import BakedVisibility
from ..scene.material import Material
from ..scene.model import DEFAULT_COLOR, Mesh
from ..scene.srgb import encode
from ..scene.vertex_normals import crease_normals, weld

SPAN = (1e-30, 1e30)
"""Sizes of a scene that 32-bit arithmetic can take."""
FAR = 16
"""Sizes of a mesh that its middle may lie off the origin before its vertices are stored about the middle."""


@dataclass
class MeshData:
    """What a file says of a mesh: vertices (n, 3), faces (m, 3), and at each vertex normals, uv (v downwards), colours.

    colors: (n, 4) uint8 sRGB with linear alpha. face_colors: (m, 4) likewise. material: None for the default colour, or
    white under colours of its own. baked: visibility that it keeps. soup: vertices at the same place become one where normals must be made.
    """

    vertices: NDArray[Any]
    faces: NDArray[Any]
    normals: NDArray[Any] | None = None
    uv: NDArray[Any] | None = None
    colors: NDArray[np.uint8] | None = None
    face_colors: NDArray[np.uint8] | None = None
    material: Material | None = None
    soup: bool = False
    baked: BakedVisibility | None = None


def build_mesh(data: MeshData, transforms: NDArray[np.float64], name: str, crease: float) -> Mesh:
    """Return ``data`` as a mesh at ``transforms`` (k, 4, 4). Raises SceneError for what cannot be drawn."""
    _check_indices(data, name)
    data = _named(data)
    _check_finite(data, name)
    positions, transforms = _centered(data.vertices, transforms, name)
    triangles = data.faces.astype(np.uint32)
    colors, uv, baked = data.colors, data.uv, data.baked
    normals = None if data.normals is None else np.asarray(data.normals, np.float32)
    if normals is None and crease > 0:
        if data.soup and uv is not None:
            positions, triangles, normals, source = _welded_normals(positions, triangles, uv, colors, crease)
            colors, uv = _picked(colors, source), uv[source]
        else:
            if data.soup:
                positions, triangles, first = weld(positions, triangles, colors)
                colors = _picked(colors, first)
            positions, triangles, normals, split = crease_normals(positions, triangles, crease)
            colors, uv = _picked(colors, split), _picked(uv, split)
            baked = baked if baked is None or split is None else baked.picked(split)
    if data.face_colors is not None:
        colors = _face_means(data.face_colors, triangles, len(positions))
    white = colors is not None and data.material is None
    return Mesh(
        positions, triangles, normals, (1.0, 1.0, 1.0) if white else DEFAULT_COLOR, colors, transforms, name,
        None if uv is None else np.nan_to_num(np.asarray(uv, np.float32), posinf=0, neginf=0),
        data.material, baked,
    )  # fmt: skip


def linear_colors(colors: NDArray[Any], factor: NDArray[Any] | None = None) -> NDArray[np.uint8]:
    """Linear colours (n, 3 or 4) in 0..1, times ``factor`` (r, g, b, alpha), as (n, 4) uint8 sRGB with linear alpha."""
    f = np.ones(4) if factor is None else np.asarray(factor, np.float64)
    out = np.full((len(colors), 4), round(255 * f[3]), np.uint8)
    given = np.nan_to_num(np.asarray(colors, np.float64))
    out[:, :3] = np.round(encode(given[:, :3] * f[:3]) * 255)
    if given.shape[1] == 4:
        out[:, 3] = np.round(np.clip(given[:, 3] * f[3], 0, 1) * 255)
    return out


def _picked(values: NDArray[Any] | None, source: NDArray[np.uint32] | None) -> NDArray[Any] | None:
    return values if values is None or source is None else values[source]


def _check_indices(data: MeshData, name: str) -> None:
    low, high = int(data.faces.min()), int(data.faces.max())
    if low < 0 or high >= len(data.vertices):
        raise SceneError(
            f"mesh '{name}': a triangle names vertex {low if low < 0 else high}; there are 0 to {len(data.vertices) - 1}"
        )


def _named(data: MeshData) -> MeshData:
    """Without vertices that no triangle names: they may lie anywhere, or be no numbers at all (points that were not seen)."""
    named = np.zeros(len(data.vertices), bool)
    named[data.faces.ravel()] = True
    if named.all():
        return data
    number = np.cumsum(named) - 1

    def kept(rows: NDArray[Any] | None) -> NDArray[Any] | None:
        return None if rows is None else rows[named]

    return replace(
        data, vertices=data.vertices[named], faces=number[data.faces],
        normals=kept(data.normals), uv=kept(data.uv), colors=kept(data.colors),
        baked=None if data.baked is None else data.baked.picked(named),
    )  # fmt: skip


def _check_finite(data: MeshData, name: str) -> None:
    vertices = data.vertices
    if math.isfinite(vertices.min()) and math.isfinite(vertices.max()):
        return
    named = int((~np.isfinite(vertices.sum(1)))[data.faces].any(1).sum())
    raise SceneError(
        f"mesh '{name}': {named} of {len(data.faces)} triangles have vertices that are not finite numbers (NaN or infinity)"
    )


def _centered(
    vertices: NDArray[Any], transforms: NDArray[np.float64], name: str
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Vertices as 32-bit floats, about their middle where they lie far from the origin: there floats are too coarse."""
    box = np.stack([vertices.min(0), vertices.max(0)]).astype(np.float64)
    check_span(f"mesh '{name}'", box)
    middle = box.mean(0)
    if np.abs(middle).max() <= FAR * (box[1] - box[0]).max():
        return vertices.astype(np.float32), transforms
    positions = np.empty(vertices.shape, np.float32)
    np.subtract(vertices, middle, out=positions, casting="same_kind")
    shifted = transforms.copy()
    shifted[:, :3, 3] += transforms[:, :3, :3] @ middle
    return positions, shifted


def check_span(what: str, box: NDArray[np.float64]) -> None:
    """32-bit floats square lengths on the way; outside this range they would overflow or vanish. Raises SceneError."""
    span = float((box[1] - box[0]).max())
    if span and not SPAN[0] <= span <= SPAN[1]:
        raise SceneError(f"{what} is {span:g} units large; it must be {SPAN[0]:g} to {SPAN[1]:g}: scale it")


def _welded_normals(
    positions: NDArray[np.float32],
    triangles: NDArray[np.uint32],
    uv: NDArray[Any],
    colors: NDArray[np.uint8] | None,
    crease: float,
) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.float32], NDArray[np.uint32]]:
    """Positions, triangles, normals as if no texture had seams, and the old vertex of each new one."""
    welded, faces, _ = weld(positions, triangles)
    smooth_positions, smooth, normals, _ = crease_normals(welded, faces, crease)
    looks = np.ascontiguousarray(np.column_stack([np.asarray(uv, np.float32).view(np.uint8).reshape(len(uv), -1), *([] if colors is None else [colors])]))  # fmt: skip
    _, alike, source = weld(positions, triangles, looks)
    seen = np.arange(len(positions), dtype=np.uint32) if source is None else source
    pairs = smooth.ravel().astype(np.int64) * len(seen) + alike.ravel()
    kept, corners = np.unique(pairs, return_inverse=True)
    point, look = kept // len(seen), kept % len(seen)
    return smooth_positions[point], corners.reshape(-1, 3).astype(np.uint32), normals[point], seen[look]


def _face_means(colors: NDArray[np.uint8], triangles: NDArray[np.uint32], count: int) -> NDArray[np.uint8]:
    """Vertex colours from those of the faces around: exact at sharp edges, whose faces share no vertex."""
    total = np.stack([sum(np.bincount(triangles[:, k], c, count) for k in range(3)) for c in colors.T], 1)
    faces = np.bincount(triangles.ravel(), minlength=count)
    return np.round(total / np.maximum(faces, 1)[:, None]).astype(np.uint8)
