"""Colours, materials and textures of trimesh's meshes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..errors import one_line
from ..scene.material import AlphaMode, ColorTexture, Material, Wrap
from ..scene.srgb import decode
from .mesh_building import MeshData
from .mtl_lines import PLACE
from .notes import Notes
from .picture_files import Texels, file_size
from .resolver import FolderResolver


class TrimeshLooks:
    """Reads how meshes look; each picture is unpacked once."""

    def __init__(self, notes: Notes, beside: FolderResolver | None = None, *, encoded: bool = False) -> None:
        """``beside``: where further pictures are found that materials name. encoded: factors are sRGB, as COLLADA's are."""
        self._notes = notes
        self._beside = beside
        self._encoded = encoded
        self._texels = Texels()
        self._textures: dict[int, ColorTexture | None] = {}
        self._materials: dict[int, Material] = {}

    def paint(self, data: MeshData, mesh: Any, name: str) -> None:
        """Set colours, material and texture coordinates of ``data``, which has the vertices of trimesh's ``mesh``."""
        visual: Any = mesh.visual
        if visual is None or not visual.defined:
            return
        if visual.kind == "vertex":
            data.colors = np.asarray(visual.vertex_colors, np.uint8)
        elif visual.kind == "face":
            data.face_colors, data.material = np.asarray(visual.face_colors), Material()
        else:
            self._textured(data, mesh, visual, name)

    def _textured(self, data: MeshData, mesh: Any, visual: Any, name: str) -> None:
        material: Any = getattr(visual, "material", None)
        uv: Any = getattr(visual, "uv", None)
        usable = np.ndim(uv) == 2 and np.shape(uv)[0] == len(mesh.vertices) and np.shape(uv)[1] >= 2
        data.material = self._material(material, name, usable)
        if usable and data.material is not None and data.material.base_color_texture is not None:
            sx, sy, ox, oy, _ = _place(material)
            data.uv = np.column_stack([uv[:, 0] * sx + ox, 1 - (np.asarray(uv[:, 1]) * sy + oy)])  # trimesh's v points upwards
            return
        colors = visual.vertex_attributes.get("color")
        if colors is not None and np.shape(colors) in ((len(mesh.vertices), 3), (len(mesh.vertices), 4)):
            from trimesh.visual.color import to_rgba

            data.colors = np.asarray(to_rgba(colors), np.uint8)
            data.material = data.material or Material()

    def _material(self, material: Any, name: str, textured: bool) -> Material | None:
        if material is None:
            return None
        key = id(material) * 2 + textured
        if key not in self._materials:
            texture = self._texture(material, name) if textured else None
            if hasattr(material, "baseColorFactor"):
                self._materials[key] = _physical(material, texture, self._encoded)
            else:
                self._materials[key] = self._older(material, texture, textured, name)
        return self._materials[key]

    def _texture(self, material: Any, name: str) -> ColorTexture | None:
        image: Any = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
        if image is None:
            return None
        if id(image) not in self._textures:
            self._textures[id(image)] = None
            try:
                wrap: Wrap = "clamp" if _place(material)[4] else "repeat"
                texels = self._texels.array(image, file_size(image))
                self._textures[id(image)] = ColorTexture(texels, (wrap, wrap), name=name)
            except Exception as error:
                self._notes.add(f"mesh '{one_line(name, 50)}': drawn without its texture ({one_line(error)})")
        return self._textures[id(image)]

    def _older(self, material: Any, texture: ColorTexture | None, textured: bool, name: str) -> Material:
        """A material of OBJ and others, whose colours are sRGB. With a picture its own colour says nothing: often it is black."""
        facts: Any = getattr(material, "kwargs", None) or {}
        title = one_line(getattr(material, "name", None) or "", 50)
        main = getattr(material, "main_color", None)
        rgba = np.ones(4) if texture is not None or main is None else _four(np.asarray(main, np.float64) / 255)
        rgba[:3] = decode(rgba[:3])
        rgba[3] *= self._dissolve(facts, title)
        if textured and "map_d" in facts:
            texture, cut = self._cut_out(texture, facts["map_d"], name)
            return _made(rgba, texture, "MASK" if cut else "BLEND", 0.5, False, title)
        return _made(rgba, texture, "BLEND" if rgba[3] < 1 else "OPAQUE", 0.5, False, title)

    def _dissolve(self, facts: dict[str, Any], title: str) -> float:
        """Alpha by ``d`` or ``Tr`` (1 - d)."""
        for key, sign in (("d", 1), ("tr", -1)):
            try:
                alpha = min(max((1 - sign) / 2 + sign * float(facts[key][-1]), 0.0), 1.0)
            except (KeyError, TypeError, ValueError, IndexError):
                continue
            if alpha > 0:
                return alpha
            # Some exporters write the one's value for the other.
            self._notes.add(
                f"material '{title}' says that it is wholly transparent ({key} {facts[key][-1]}); it is drawn solid"
            )
            return 1.0
        return 1.0

    def _cut_out(self, texture: ColorTexture | None, words: Any, name: str) -> tuple[ColorTexture | None, bool]:
        """The texture with alpha from the picture that ``map_d`` names: from its own alpha, or else its brightness."""
        try:
            if self._beside is None:
                raise ValueError("its folder is not known")
            file = " ".join(words)
            texels = self._texels.unpack(self._beside.get(file))
            alpha = texels[..., 3] if texels.shape[2] == 4 else texels.max(2)
            base = np.full((*alpha.shape, 3), 255, np.uint8) if texture is None else texture.array[..., :3]
            size = max(base.shape[:2], alpha.shape, key=math.prod)
            four = np.concatenate([_resized(base, size), _resized(alpha, size)[..., None]], 2)
            return ColorTexture(four, ("repeat", "repeat") if texture is None else texture.wrap, name=name), True
        except Exception as error:
            self._notes.add(f"mesh '{one_line(name, 50)}': drawn without its cut-outs ({one_line(error)})")
            return texture, False


def _resized(texels: NDArray[np.uint8], size: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return texels (h, w) or (h, w, 3) with ``size`` rows and columns."""
    if texels.shape[:2] == size:
        return texels
    return np.asarray(Image.fromarray(texels).resize((size[1], size[0]), Image.Resampling.BILINEAR))


def _place(material: Any) -> tuple[float, ...]:
    """Scale of u and v, offset of u and v, and whether the picture is clamped, of OBJ's materials."""
    words = (getattr(material, "kwargs", None) or {}).get(PLACE, ())
    return tuple(map(float, words)) if len(words) == 5 else (1.0, 1.0, 0.0, 0.0, 0.0)


def _physical(material: Any, texture: ColorTexture | None, encoded: bool) -> Material:
    """A material of glTF's kind, whose factors are linear."""
    factor = material.baseColorFactor
    rgba = np.ones(4) if factor is None else _four(np.asarray(factor, np.float64) / 255)
    if encoded:
        rgba[:3] = decode(rgba[:3])
    mode: AlphaMode = {"MASK": "MASK", "BLEND": "BLEND"}.get(str(material.alphaMode).upper(), "OPAQUE")  # type: ignore[assignment]
    cutoff = 0.5 if material.alphaCutoff is None else float(material.alphaCutoff)
    return _made(rgba, texture, mode, cutoff, bool(material.doubleSided), one_line(getattr(material, "name", None) or "", 50))


def _four(values: NDArray[np.float64]) -> NDArray[np.float64]:
    rgba = np.ones(4)
    rgba[: min(len(values), 4)] = np.clip(np.nan_to_num(values[:4]), 0, 1)
    return rgba


def _made(
    rgba: NDArray[np.float64], texture: ColorTexture | None, mode: AlphaMode, cutoff: float, both_sides: bool, name: str
) -> Material:
    r, g, b, a = (float(value) for value in rgba)
    return Material((r, g, b, a), texture, mode, cutoff, double_sided=both_sides, name=name)
