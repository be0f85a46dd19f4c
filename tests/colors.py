"""Colours of meshes at their vertices, worked out without OpenGL."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssao_gl.scene.model import Mesh
from ssao_gl.scene.srgb import decode, encode
from ssao_gl.scene.texels import texels_at


def colors_at_vertices(mesh: Mesh) -> NDArray[np.uint8]:
    """(n, 4) sRGB with linear alpha; at the corners of a picture those of its corner texels."""
    alpha = 1.0 if mesh.material is None else mesh.material.base_color[3]
    colors = np.tile([*mesh.color, alpha], (len(mesh.positions), 1))
    if mesh.vertex_colors is not None:
        colors = colors * mesh.vertex_colors / 255
    if mesh.texture is not None and mesh.uv is not None:
        half = 0.5 / np.array(mesh.texture.array.shape[1::-1])
        texels = texels_at(mesh.texture, np.clip(mesh.uv, half, 1 - half))
        colors[:, :3] = encode(decode(colors[:, :3]) * decode(texels[:, :3]))
        colors[:, 3] *= texels[:, 3]
    return np.round(colors * 255).astype(np.uint8)
