"""Scenes as glTF documents, mesh by mesh and vertex by vertex: what is not a glTF file is baked as one."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from PIL import Image

from ..scene.material import ColorTexture, Material
from ..scene.model import Mesh, Scene
from ..scene.srgb import decode
from .gltf_document import Document, Tree
from .gltf_materials import NEAREST, WRAPS
from .gltf_writing import INDICES, GltfWriter
from .resolver import FolderResolver

UNSIGNED = 65535


def writer_of(scene: Scene) -> GltfWriter:
    """Return a writer with the scene's meshes that have triangles, in their order, one primitive each, and a node for each of their transforms."""
    empty = Document({"asset": {"version": "2.0", "generator": "ssao_gl"}}, FolderResolver(lambda name: None), 0)
    writer = GltfWriter(empty)
    tree = writer.tree | {"meshes": [], "nodes": [], "scenes": [{"nodes": []}], "scene": 0}
    writer.tree = tree
    materials = _Materials(writer)
    for mesh in (mesh for mesh in scene.meshes if mesh.is_placed):
        primitive = _primitive(writer, mesh) | {"material": materials.number(mesh)}
        tree["meshes"].append({"name": mesh.name, "primitives": [primitive]} if mesh.name else {"primitives": [primitive]})
        for transform in mesh.transforms:
            node: Tree = {"mesh": len(tree["meshes"]) - 1}
            if not np.array_equal(transform, np.eye(4)):
                node["matrix"] = transform.T.ravel().tolist()
            tree["scenes"][0]["nodes"].append(len(tree["nodes"]))
            tree["nodes"].append(node)
    return writer


def _primitive(writer: GltfWriter, mesh: Mesh) -> Tree:
    positions = writer.accessor(mesh.positions.astype(np.float32))
    writer.tree["accessors"][positions] |= {
        "min": mesh.positions.min(0, initial=np.inf).tolist(), "max": mesh.positions.max(0, initial=-np.inf).tolist(),
    }  # fmt: skip
    attributes = {"POSITION": positions}
    if mesh.normals is not None:
        length = np.linalg.norm(mesh.normals.astype(np.float64), axis=1, keepdims=True)
        unit = np.where(length > 0, mesh.normals / np.where(length > 0, length, 1), (0, 0, 1))
        attributes["NORMAL"] = writer.accessor(unit.astype(np.float32))
    if mesh.uv is not None:
        attributes["TEXCOORD_0"] = writer.accessor(mesh.uv.astype(np.float32))
    if mesh.vertex_colors is not None:
        linear = mesh.vertex_colors / 255
        linear[:, :3] = decode(linear[:, :3])
        attributes["COLOR_0"] = writer.accessor(np.round(linear * UNSIGNED).astype(np.uint16), normalized=True)
    indices = writer.accessor(mesh.triangles.reshape(-1, 1).astype(np.uint32), target=INDICES)
    return {"attributes": attributes, "indices": indices}


class _Materials:
    """Numbers of materials, each written once."""

    def __init__(self, writer: GltfWriter) -> None:
        self._writer = writer
        self._known: dict[Any, int] = {}
        self._textures: dict[int, int] = {}

    def number(self, mesh: Mesh) -> int:
        key = mesh.color if mesh.material is None else id(mesh.material)
        if key not in self._known:
            self._known[key] = self._writer.add_material(self._entry(mesh.material, mesh.color))
        return self._known[key]

    def _entry(self, material: Material | None, color: tuple[float, float, float]) -> Tree:
        if material is None:
            rgb = decode(color).tolist()
            return {"pbrMetallicRoughness": {"baseColorFactor": [*rgb, 1.0], "metallicFactor": 0.0}}
        surface: Tree = {
            "baseColorFactor": list(material.base_color),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        if material.base_color_texture is not None:
            surface["baseColorTexture"] = {"index": self._texture(material.base_color_texture)}
        entry: Tree = {"pbrMetallicRoughness": surface, "alphaMode": material.alpha_mode}
        if material.alpha_mode == "MASK":
            entry["alphaCutoff"] = max(material.alpha_cutoff, 0.0)
        if any(material.emissive):
            entry["emissiveFactor"] = [min(max(value, 0.0), 1.0) for value in material.emissive]
        if material.double_sided:
            entry["doubleSided"] = True
        return entry | ({"name": material.name} if material.name else {})

    def _texture(self, texture: ColorTexture) -> int:
        if id(texture) not in self._textures:
            out = io.BytesIO()
            Image.fromarray(texture.array).save(out, "PNG")
            number = self._writer.picture(out.getvalue(), texture.name or "base color")
            sampler = self._writer.tree["samplers"][self._writer.tree["textures"][number]["sampler"]]
            wraps = {wrap: code for code, wrap in WRAPS.items()}
            sampler["wrapS"], sampler["wrapT"] = (wraps[wrap] for wrap in texture.wrap)
            if texture.nearest:
                sampler["magFilter"] = NEAREST
            if not texture.mipmaps:
                sampler["minFilter"] = NEAREST if texture.nearest else 9729
            self._textures[id(texture)] = number
        return self._textures[id(texture)]
