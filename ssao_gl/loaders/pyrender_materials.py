"""Materials and textures of pyrender."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.material import AlphaMode, ColorTexture, Material, Wrap
from .notes import Notes

WRAPS: dict[int, Wrap] = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
NEAREST = 9728
MIPMAPS = frozenset({9984, 9985, 9986, 9987})
DEFAULT = (0.6038, 0.6038, 0.6038, 1.0)
"""Linear light of the grey (.8) that has no material."""


class PyrenderLooks:
    """Reads materials; each picture is converted once."""

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._textures: dict[int, ColorTexture | None] = {}

    def material(self, primitive: Any, count: int) -> tuple[NDArray[np.float32] | None, Material]:
        """Texture coordinates (n, 2), v downwards, or None; and the material."""
        given, uv = primitive.material, primitive.texcoord_0
        factor = getattr(given, "baseColorFactor", None)
        if given is None or factor is None:
            return None, Material(DEFAULT if primitive.color_0 is None else (1.0, 1.0, 1.0, 1.0))
        r, g, b, a = (float(value) for value in np.clip(np.asarray([*factor, 1.0][:4], np.float64), 0, 1))
        texture = self._texture(getattr(given, "baseColorTexture", None))
        usable = texture is not None and np.ndim(uv) == 2 and np.shape(uv)[0] == count
        mode: AlphaMode = {"MASK": "MASK", "BLEND": "BLEND"}.get(str(getattr(given, "alphaMode", "")), "OPAQUE")  # type: ignore[assignment]
        material = Material(
            (r, g, b, a), texture if usable else None, mode, float(getattr(given, "alphaCutoff", None) or 0.5),
            metallic=_share(given, "metallicFactor"), roughness=_share(given, "roughnessFactor"),
            double_sided=bool(getattr(given, "doubleSided", False)), name=str(getattr(given, "name", None) or ""),
        )  # fmt: skip
        if not usable:
            return None, material
        return np.column_stack([uv[:, 0], 1 - np.asarray(uv[:, 1], np.float64)]).astype(
            np.float32
        ), material  # v points up there

    def _texture(self, texture: Any) -> ColorTexture | None:
        source = getattr(texture, "source", None)
        if source is None:
            return None
        if id(texture) not in self._textures:
            try:
                self._textures[id(texture)] = _converted(texture, np.asarray(source))
            except Exception as error:
                self._notes.add(f"a texture of pyrender is left out ({error})")
                self._textures[id(texture)] = None
        return self._textures[id(texture)]


def _share(material: Any, name: str) -> float:
    """A factor in 0..1. Without a texture of it; what has one is more often no metal than one."""
    value = getattr(material, name, None)
    if name == "metallicFactor" and (value is None or getattr(material, "metallicRoughnessTexture", None) is not None):
        return 0.0
    return 1.0 if value is None else float(np.clip(np.nan_to_num(float(value), nan=1.0), 0, 1))


def _converted(texture: Any, pixels: NDArray[Any]) -> ColorTexture:
    """Grey, grey and alpha, RGB or RGBA, of bytes or floats in 0..1. Row 0 is on top."""
    pixels = pixels[..., None] if pixels.ndim == 2 else pixels
    if pixels.dtype != np.uint8:
        pixels = np.round(np.clip(np.nan_to_num(pixels), 0, 1) * 255).astype(np.uint8)
    if pixels.shape[2] < 3:
        pixels = np.concatenate([pixels[..., [0, 0, 0]], pixels[..., 1:]], 2)
    sampler = getattr(texture, "sampler", None)
    least, most = getattr(sampler, "minFilter", None), getattr(sampler, "magFilter", None)
    s, t = (WRAPS.get(getattr(sampler, f"wrap{axis}", 0), "repeat") for axis in "ST")
    return ColorTexture(
        np.ascontiguousarray(pixels), (s, t), most == NEAREST, least is None or least in MIPMAPS, texture.name or ""
    )
