"""The parts of a glTF file that are drawn, and nothing else: what trimesh never sees it can neither believe nor unpack.

Numbers stay as they are in the file, so that messages can name them; parts without use become empty.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from typing import Any

from ..errors import SceneError
from .gltf_nodes import Placed, Tree, index

TRIANGLES, STRIP, FAN = 4, 5, 6
LARGEST = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}
"""Of the types of integers that are normalized."""
ACCESSOR = ("componentType", "count", "type", "bufferView", "byteOffset", "normalized", "sparse")
VIEW = ("buffer", "byteLength", "byteOffset", "byteStride")
BUFFER = ("byteLength", "uri")
ATTRIBUTES = ("POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0")
MAX_PRIMITIVES = 10_000
"""trimesh takes some 0.4 milliseconds for each."""
MAX_INSTANCES = 100_000
"""And 0.05 for each node that places one."""

DRACO, GLOSS, WEBP = "KHR_draco_mesh_compression", "KHR_materials_pbrSpecularGlossiness", "EXT_texture_webp"
Used = defaultdict[str, set[int]]
Images = dict[tuple[tuple[str, Any], ...], int]
"""Where an image is -> its number."""


def drawn(tree: Tree, placed: list[Placed]) -> Tree:
    """A tree with the triangles of ``placed`` meshes and the base colours of their materials. Raises SceneError.

    Each primitive becomes a mesh of its own: trimesh gives those of one mesh names at random.
    """
    used: Used = defaultdict(set)
    meshes, nodes = _meshes(tree, placed, used)
    found: Images = {}
    materials = [
        _material(entry, tree, found) if n in used["materials"] else {} for n, entry in enumerate(tree.get("materials", []))
    ]
    images = [dict(image) for image in found]
    accessors = _only(
        tree.get("accessors", []), used["accessors"], ACCESSOR, {"componentType": 5121, "count": 0, "type": "SCALAR"}
    )
    used["bufferViews"] |= {index(entry["bufferView"]) for entry in (*accessors, *images) if "bufferView" in entry}
    views = _only(tree.get("bufferViews", []), used["bufferViews"], VIEW, {"buffer": 0, "byteLength": 0})
    used["buffers"] |= {index(entry["buffer"]) for entry in views}
    buffers = _only(tree.get("buffers", []), used["buffers"], BUFFER, {"byteLength": 0, "uri": "data:;base64,"})
    return {
        "asset": _kept(tree.get("asset", {}), "version"),
        "buffers": buffers,
        "bufferViews": views,
        "accessors": accessors,
        "images": images,
        "textures": [{"source": number} for number in range(len(images))],
        "materials": materials,
        "meshes": meshes,
        "nodes": nodes,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "scene": 0,
    }


def _only(entries: list[Tree], used: set[int], keys: tuple[str, ...], empty: Tree) -> list[Tree]:
    return [_kept(entry, *keys) if number in used else empty for number, entry in enumerate(entries)]


def _kept(entry: Mapping[str, Any], *keys: str) -> Tree:
    return {key: entry[key] for key in keys if key in entry}


def _meshes(tree: Tree, placed: list[Placed], used: Used) -> tuple[list[Tree], list[Tree]]:
    """A mesh for each primitive of triangles, and the nodes that place them."""
    meshes: list[Tree] = []
    nodes: list[Tree] = []
    parts: dict[int, list[tuple[int, float]]] = {}
    for number, world in placed:
        if number not in parts:
            mesh = tree["meshes"][number]
            if any(p.get("mode") == FAN for p in mesh["primitives"]):
                raise SceneError("has fans of triangles, which cannot be read; export it as triangles")
            primitives = [p for p in mesh["primitives"] if p.get("mode", TRIANGLES) in (TRIANGLES, STRIP)]
            parts[number] = [(len(meshes) + i, _step(p, tree)) for i, p in enumerate(primitives)]
            meshes += [{"name": str(mesh["name"])[:200], "primitives": [_primitive(p, tree, used)]} for p in primitives]
        nodes += [
            {"mesh": part, "name": str(len(nodes) + i), "matrix": (world * [step, step, step, 1]).T.ravel().tolist()}
            for i, (part, step) in enumerate(parts[number])
        ]
        if len(meshes) > MAX_PRIMITIVES or len(nodes) > MAX_INSTANCES:
            raise SceneError(
                f"draws more than {MAX_PRIMITIVES} primitives, or {MAX_INSTANCES} instances of them,"
                " which cannot be read in sensible time; merge them"
            )
    if not meshes:
        lines = any(mesh["primitives"] for mesh in tree.get("meshes", []))
        raise SceneError("holds no triangles" + (", only lines or points" if lines else ""))
    return meshes, nodes


def _step(primitive: Mapping[str, Any], tree: Tree) -> float:
    """What 1 in its positions stands for: integers may be normalized (KHR_mesh_quantization), which trimesh leaves as they are."""
    accessor = tree["accessors"][index(primitive["attributes"]["POSITION"])]
    return 1 / LARGEST.get(accessor["componentType"], 1) if accessor.get("normalized") else 1.0


def _primitive(primitive: Mapping[str, Any], tree: Tree, used: Used) -> Tree:
    made = _kept(primitive, "indices", "mode", "material")
    made["attributes"] = _kept(primitive["attributes"], *ATTRIBUTES)
    numbers = [index(number) for number in (*made["attributes"].values(), *([made["indices"]] if "indices" in made else []))]
    used["accessors"].update(numbers)
    if "material" in made:
        used["materials"].add(index(made["material"]))
    packed = primitive.get("extensions", {}).get(DRACO)
    if packed is not None and any("bufferView" not in tree["accessors"][number] for number in numbers):
        made["extensions"] = {DRACO: _kept(packed, "bufferView", "attributes")}
        used["bufferViews"].add(index(packed["bufferView"]))
    return made


def _material(material: Mapping[str, Any], tree: Tree, images: Images) -> Tree:
    """Its base colour, or the diffuse one of the older model; what of it is broken is left out."""
    gloss = material.get("extensions", {}).get(GLOSS)
    facts, name = (material.get("pbrMetallicRoughness", {}), "baseColor") if gloss is None else (gloss, "diffuse")
    factor, texture = facts.get(f"{name}Factor"), facts.get(f"{name}Texture")
    made: Tree = {}
    if isinstance(factor, list) and len(factor) == 4 and all(isinstance(f, int | float) and math.isfinite(f) for f in factor):
        made["baseColorFactor"] = [min(max(float(f), 0), 1) for f in factor]
    image = None if texture is None else _image(texture, tree)
    if image is not None:
        made["baseColorTexture"] = {"index": images.setdefault(tuple(image.items()), len(images))}
    return {"pbrMetallicRoughness": made}


def _image(texture: Mapping[str, Any], tree: Tree) -> Tree | None:
    try:
        entry = tree["textures"][index(texture["index"])]
        source = entry.get("extensions", {}).get(WEBP, entry)["source"]
        image = _kept(tree["images"][index(source)], "bufferView", "uri")
        if "bufferView" in image:
            tree["bufferViews"][index(image["bufferView"])]
        return image if "bufferView" in image or isinstance(image.get("uri"), str) else None
    except (LookupError, TypeError, AttributeError):
        return None
