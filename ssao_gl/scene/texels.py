"""Textures sampled on the CPU, as OpenGL samples their largest level (OpenGL ES 3.0, 3.8.10), for rays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import srgb
from .material import ColorTexture, Wrap
from .model import Mesh

F64 = NDArray[np.float64]


def alpha_at(mesh: Mesh, triangles: NDArray[np.integer], u: F64, v: F64) -> F64:
    """Return alpha (n,) in 0..1 at barycentric coordinates u and v (n,) of the second and third corner of ``triangles``."""
    corners = mesh.triangles[triangles]
    weights = np.stack([1 - u - v, u, v], -1)
    alpha = np.full(len(corners), 1.0 if mesh.material is None else mesh.material.base_color[3], np.float64)
    if mesh.vertex_colors is not None:
        alpha *= (weights * mesh.vertex_colors[corners, 3]).sum(1) / 255
    if mesh.texture is not None and mesh.uv is not None:
        alpha *= texels_at(mesh.texture, (weights[..., None] * mesh.uv[corners]).sum(1))[:, 3]
    return alpha


def colors_at(mesh: Mesh, triangles: NDArray[np.integer], u: F64, v: F64) -> F64:
    """Return base colour (n, 3) as linear light at barycentric coordinates u and v (n,), as :func:`alpha_at` does alpha."""
    corners = mesh.triangles[triangles]
    weights = np.stack([1 - u - v, u, v], -1)[..., None]
    linear = np.broadcast_to(srgb.decode(mesh.color), (len(corners), 3)).copy()
    if mesh.vertex_colors is not None:
        linear *= (weights * srgb.decode(mesh.vertex_colors[corners, :3] / 255)).sum(1)
    if mesh.texture is not None and mesh.uv is not None:
        texels = texels_at(mesh.texture, (weights * mesh.uv[corners]).sum(1))[:, :3]
        linear *= texels if mesh.texture.linear else srgb.decode(texels)
    return linear


def texels_at(texture: ColorTexture, uv: F64) -> F64:
    """Return (n, 4) red, green, blue as they are stored (sRGB) and alpha, in 0..1, at uv (n, 2)."""
    h, w = texture.array.shape[:2]
    at = uv.astype(np.float64) * (w, h)
    if texture.nearest:
        return _texels(texture, np.floor(at).astype(np.int64))
    at -= 0.5
    low = np.floor(at).astype(np.int64)
    (x, y) = np.moveaxis(at - low, -1, 0)[..., None]
    rows = [(1 - x) * _texels(texture, low + (0, dy)) + x * _texels(texture, low + (1, dy)) for dy in (0, 1)]
    return np.asarray((1 - y) * rows[0] + y * rows[1])


def _texels(texture: ColorTexture, at: NDArray[np.int64]) -> F64:
    """Return the texels (n, 4) of columns and rows (n, 2), which may lie outside the picture."""
    h, w, channels = texture.array.shape
    x, y = (_wrapped(at[:, axis], texture.wrap[axis], size) for axis, size in enumerate((w, h)))
    texels = np.ones((len(at), 4))
    texels[:, :channels] = texture.array[y, x] / 255
    return texels


def _wrapped(index: NDArray[np.int64], kind: Wrap, size: int) -> NDArray[np.int64]:
    """Return ``index`` within the picture (OpenGL ES 3.0, table 3.17)."""
    if kind == "clamp":
        return np.clip(index, 0, size - 1)
    if kind == "repeat":
        return index % size
    folded = index % (2 * size)
    return np.minimum(folded, 2 * size - 1 - folded)
