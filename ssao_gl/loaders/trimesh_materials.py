"""Colours, materials and textures of trimesh's meshes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import one_line
from ..scene.material import AlphaMode, ColorTexture, Material
from ..scene.srgb import decode
from .mesh_building import MeshData
from .notes import Notes
from .picture_files import Texels, file_size


class TrimeshLooks:
    """Reads how meshes look; each picture is unpacked once."""

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
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
            data.uv = np.column_stack([uv[:, 0], 1 - np.asarray(uv[:, 1])])  # trimesh's v points upwards
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
            self._materials[key] = _material(material, texture)
        return self._materials[key]

    def _texture(self, material: Any, name: str) -> ColorTexture | None:
        image: Any = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
        if image is None:
            return None
        if id(image) not in self._textures:
            self._textures[id(image)] = None
            try:
                self._textures[id(image)] = ColorTexture(self._texels.array(image, file_size(image)), name=name)
            except Exception as error:
                self._notes.add(f"mesh '{one_line(name, 50)}': drawn without its texture ({one_line(error)})")
        return self._textures[id(image)]


def _material(material: Any, texture: ColorTexture | None) -> Material:
    """glTF's own, whose factors are linear; or the older kind of OBJ and others, whose colours are sRGB."""
    name = one_line(getattr(material, "name", None) or "", 50)
    if hasattr(material, "baseColorFactor"):
        factor = material.baseColorFactor
        rgba = np.ones(4) if factor is None else _four(np.asarray(factor, np.float64) / 255)
        mode: AlphaMode = {"MASK": "MASK", "BLEND": "BLEND"}.get(str(material.alphaMode).upper(), "OPAQUE")  # type: ignore[assignment]
        cutoff = 0.5 if material.alphaCutoff is None else float(material.alphaCutoff)
        return _made(rgba, texture, mode, cutoff, bool(material.doubleSided), name)
    main = getattr(material, "main_color", None)
    if texture is not None or main is None:
        return _made(np.ones(4), texture, "OPAQUE", 0.5, False, name)
    rgba = _four(np.asarray(main, np.float64) / 255)
    rgba[:3] = decode(rgba[:3])
    return _made(rgba, texture, "BLEND" if rgba[3] < 1 else "OPAQUE", 0.5, False, name)


def _four(values: NDArray[np.float64]) -> NDArray[np.float64]:
    rgba = np.ones(4)
    rgba[: min(len(values), 4)] = np.clip(np.nan_to_num(values[:4]), 0, 1)
    return rgba


def _made(
    rgba: NDArray[np.float64], texture: ColorTexture | None, mode: AlphaMode, cutoff: float, both_sides: bool, name: str
) -> Material:
    r, g, b, a = (float(value) for value in rgba)
    return Material((r, g, b, a), texture, mode, cutoff, double_sided=both_sides, name=name)
