"""Primitives of glTF meshes as triangles, morphed and skinned as their node stands (glTF 2.0, 3.7)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.projection import Matrix
from .gltf_accessors import raw, values
from .gltf_baked import AO, baked_visibility
from .gltf_document import Document, Tree
from .gltf_draco import DRACO, unpack_draco
from .gltf_materials import Materials, placed
from .gltf_skins import joint_matrices, skinned
from .mesh_building import MeshData, linear_colors
from .strips import fan_triangles, strip_triangles

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
MODES = (POINTS, TRIANGLES, STRIP, FAN)
Attributes = dict[str, NDArray[Any]]


def primitive_data(
    document: Document, materials: Materials, primitive: Tree, weights: list[float], skin: Tree | None, worlds: dict[int, Matrix]
) -> MeshData:  # fmt: skip
    """The triangles of a primitive (points: no faces) with the given morph weights, and in the world where it is skinned."""
    faces, attributes = primitive_content(document, primitive)
    count = len(attributes["POSITION"])
    document.take(24 * count)
    for name in [name for name in attributes if len(attributes[name]) != count]:
        document.notes.add(f"attribute {name} has {len(attributes[name])} entries for {count} vertices, and is not used")
        del attributes[name]
    if any(weights):
        _morph(document, attributes, primitive.get("targets", []), weights)
    if skin is not None:
        attributes |= _skinned(document, primitive, attributes, skin, worlds)
    normals = attributes.get("NORMAL")
    if normals is not None and normals.shape[1] != 3:
        normals = None
    data = MeshData(attributes["POSITION"], faces, normals)
    if data.vertices.shape[1] != 3:
        raise SceneError("has positions that are not VEC3; it is broken")
    return _painted(data, attributes, materials, primitive)


def primitive_content(document: Document, primitive: Tree) -> tuple[NDArray[Any], Attributes]:
    """Faces (m, 3) and the attributes that are drawn."""
    accessors = primitive["attributes"]
    names = [name for name in accessors if name in ("POSITION", "NORMAL", "COLOR_0", AO) or name.startswith("TEXCOORD_")]
    packed = primitive.get("extensions", {}).get(DRACO)
    if packed is not None and "bufferView" not in document.entry("accessors", accessors["POSITION"]):
        faces, found = unpack_draco(document, packed, primitive)
        return faces, {name: values(document, accessors[name], name) for name in names if name not in found} | found
    attributes = {name: values(document, accessors[name], name) for name in names}
    mode = primitive.get("mode", TRIANGLES)
    if "indices" not in primitive:
        indices, restart = np.arange(len(attributes["POSITION"])), -1
    else:
        rows = raw(document, primitive["indices"], "indices")
        if rows.dtype.kind != "u" or rows.shape[1] != 1:
            raise SceneError("has indices that are not unsigned integers; it is broken")
        document.take(8 * len(rows))
        indices, restart = rows.ravel().astype(np.int64), int(np.iinfo(rows.dtype).max)
    if mode == POINTS:
        usable = {name: rows for name, rows in attributes.items() if len(rows) > indices.max(initial=-1)}
        return np.zeros((0, 3), np.int64), {name: rows[indices] for name, rows in usable.items()}
    if mode == TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3), attributes
    document.take(24 * len(indices))
    return (strip_triangles if mode == STRIP else fan_triangles)(indices, restart), attributes


def _morph(document: Document, attributes: Attributes, targets: list[Tree], weights: list[float]) -> None:
    """Add the targets' displacements, weighted (glTF 2.0, 3.7.2.2)."""
    for target, weight in zip(targets, weights, strict=False):
        for name in set(target) & set(attributes) if weight else ():
            offset = values(document, target[name], name)
            base = attributes[name]
            if len(offset) != len(base):
                raise SceneError(f"has a morph target of {len(offset)} entries for {len(base)} vertices; it is broken")
            width = min(offset.shape[1], base.shape[1])  # tangents and colours may have one more
            document.take(base.nbytes)
            moved = base.astype(np.float64)
            moved[:, :width] += weight * offset[:, :width]
            attributes[name] = moved


def _skinned(document: Document, primitive: Tree, attributes: Attributes, skin: Tree, worlds: dict[int, Matrix]) -> Attributes:
    """Positions and normals in the world."""
    sets = [name[7:] for name in sorted(primitive["attributes"]) if name.startswith("JOINTS_")]
    joints: list[NDArray[Any]] = []
    weights: list[NDArray[Any]] = []
    for number in sets:
        if f"WEIGHTS_{number}" in primitive["attributes"]:
            for found, name in ((joints, "JOINTS"), (weights, "WEIGHTS")):
                held = attributes.get(f"{name}_{number}")
                found.append(values(document, primitive["attributes"][f"{name}_{number}"]) if held is None else held)
    if not joints:
        return {}
    document.take(len(attributes["POSITION"]) * 150)
    return skinned(attributes, np.concatenate(joints, 1), np.concatenate(weights, 1), joint_matrices(document, skin, worlds))


def _painted(data: MeshData, attributes: Attributes, materials: Materials, primitive: Tree) -> MeshData:
    """Its material, texture coordinates and colours: COLOR_0 is linear, and takes the material's factor with it."""
    colors = attributes.get("COLOR_0")
    if colors is not None and colors.shape[1] not in (3, 4):
        colors = None
    if "material" in primitive:
        surface = materials.surface(primitive["material"])
        data.material = surface.material
        uv = attributes.get(f"TEXCOORD_{surface.coordinates}")
        if surface.material.base_color_texture is not None and uv is not None and uv.shape[1] == 2:
            data.uv = placed(uv, surface.transform)
    data.baked = baked_visibility(attributes, colors, materials, primitive)
    if colors is not None:
        factor = np.ones(4) if data.material is None else np.array(data.material.base_color)
        data.colors = linear_colors(colors, factor)
        if data.material is not None:
            data.material = materials.without_factor(primitive["material"])
    return data
