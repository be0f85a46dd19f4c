"""Materials: base colour and alpha of a surface, and what later light will need of it (glTF 2.0, 3.9)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from . import srgb

if TYPE_CHECKING:
    from .model import Mesh

AlphaMode = Literal["OPAQUE", "MASK", "BLEND"]
Wrap = Literal["repeat", "mirror", "clamp"]
Color = tuple[float, float, float]

CHUNK = 1 << 18
"""Vertices a step."""


@dataclass(frozen=True, eq=False)
class ColorTexture:
    """A picture of base colour: ``array`` (h, w, 3 or 4) uint8, sRGB with linear alpha, row 0 on top, which is v = 0.

    wrap: what u and v do outside 0..1. nearest: texels are not blended where they are magnified. mipmaps: smaller copies
    are used where they are minified.
    """

    array: NDArray[np.uint8]
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    nearest: bool = False
    mipmaps: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        a = self.array
        if a.ndim != 3 or a.shape[2] not in (3, 4) or a.dtype != np.uint8 or 0 in a.shape:
            raise SceneError(f"texture '{self.name}': must be uint8 of shape (h, w, 3 or 4), got {a.dtype} {a.shape}")
        if any(kind not in ("repeat", "mirror", "clamp") for kind in self.wrap):
            raise SceneError(f"texture '{self.name}': wrap is {self.wrap}; each must be repeat, mirror or clamp")

    @property
    def has_alpha(self) -> bool:
        """Whether some texel is not opaque."""
        return self.array.shape[2] == 4 and bool((self.array[..., 3] < 255).any())


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface looks: base colour = ``base_color`` x texture x vertex colours, multiplied as linear light.

    base_color: linear (r, g, b, alpha) in 0..1. alpha_mode: OPAQUE ignores alpha; MASK cuts out what is below
    ``alpha_cutoff``; BLEND mixes with what is behind. metallic, roughness and emissive (linear r, g, b) are kept for light
    that is yet to come, double_sided too: every surface is drawn from both sides today.
    """

    base_color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    base_color_texture: ColorTexture | None = None
    alpha_mode: AlphaMode = "OPAQUE"
    alpha_cutoff: float = 0.5
    emissive: Color = (0.0, 0.0, 0.0)
    metallic: float = 1.0
    roughness: float = 1.0
    double_sided: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        if len(self.base_color) != 4 or not all(0 <= value <= 1 for value in self.base_color):
            raise SceneError(f"material '{self.name}': base_color must be four numbers from 0 to 1, got {self.base_color}")
        if self.alpha_mode not in ("OPAQUE", "MASK", "BLEND"):
            raise SceneError(f"material '{self.name}': alpha_mode '{self.alpha_mode}'; must be OPAQUE, MASK or BLEND")
        if not math.isfinite(self.alpha_cutoff):
            raise SceneError(f"material '{self.name}': alpha_cutoff is {self.alpha_cutoff:g}; it must be finite")

    @property
    def color(self) -> Color:
        """``base_color`` without alpha, sRGB."""
        return srgb.encoded_rgb(self.base_color[:3])


def colors_at_vertices(mesh: Mesh) -> tuple[Color, NDArray[np.uint8] | None]:
    """Return a mesh's colour (sRGB) and vertex colours ((n, 4) uint8 sRGB or None), its texture taken at the vertices.

    For drawing without texture coordinates: the nearest texel of each vertex, so that detail between vertices is lost.
    """
    material = mesh.material
    texture = None if material is None else material.base_color_texture
    if material is None or texture is None or mesh.uv is None:
        return mesh.color, mesh.vertex_colors
    out = np.empty((len(mesh.uv), 4), np.uint8)
    factor = np.array(material.base_color)
    plain = mesh.vertex_colors is None and bool((factor == 1).all())
    for start in range(0, len(out), CHUNK):
        part = slice(start, start + CHUNK)
        texels = _nearest(texture, mesh.uv[part])
        if not plain:
            light = srgb.decode(texels[:, :3] / 255) * factor[:3]
            alpha = texels[:, 3] / 255 * factor[3]
            if mesh.vertex_colors is not None:
                light *= srgb.decode(mesh.vertex_colors[part, :3] / 255)
                alpha *= mesh.vertex_colors[part, 3] / 255
            texels = np.round(np.column_stack([srgb.encode(light), alpha]) * 255).astype(np.uint8)
        out[part] = texels
    return (1.0, 1.0, 1.0), out


def _nearest(texture: ColorTexture, uv: NDArray[np.float32]) -> NDArray[np.uint8]:
    """(n, 4) texels at uv (n, 2); the corners of the unit square are the middles of the picture's corner texels."""
    h, w, channels = texture.array.shape
    x, y = (
        (_wrapped(uv[:, axis].astype(np.float64), texture.wrap[axis], size) * (size - 1)).round().astype(np.int64)
        for axis, size in enumerate((w, h))
    )
    texels = np.full((len(uv), 4), 255, np.uint8)
    texels[:, :channels] = texture.array[y % h, x % w]
    return texels


def _wrapped(t: NDArray[np.float64], kind: Wrap, size: int) -> NDArray[np.float64]:
    """``t`` within 0..1."""
    if kind == "clamp":
        return np.clip(t, 0, 1)
    if kind == "mirror":
        return 1 - np.abs(1 - t % 2)
    last = max(size - 1, 1)
    return (t * last % size) / last
