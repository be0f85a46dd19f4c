"""A GLB file with much that baking has nothing to do with."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from ..loaders.gltf_parts import FACES, QUAD, UV, Parts


def rich_glb() -> bytes:
    """Two quads at right angles, one skinned and morphed, animated; materials, lights, variants, extras, a chunk of its own."""
    parts = Parts(
        extensionsUsed=["KHR_lights_punctual", "KHR_materials_variants", "KHR_materials_clearcoat", "EXT_of_nobody"],
        extensions={
            "KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3.5e-05}]},
            "KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]},
            "EXT_of_nobody": {"says": "é"},
        },
        extras={"of": ["the", "asset"], "n": 1.0},
    )
    parts.texture([[[200, 100, 50]] * 2] * 2)
    parts.tree["materials"][0] |= {
        "name": "wood",
        "doubleSided": True,
        "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.25}},
        "extras": {"grain": 3},
    }
    parts.tree["materials"].append({"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 1]}})
    four = np.ones((4, 1))
    normals = parts.accessor((four * [0, 0, 1]).astype("f4"))
    uv = parts.accessor(UV)
    skinned = bounded(parts, NORMAL=normals, TEXCOORD_0=uv)
    skinned["attributes"] |= {
        "COLOR_0": parts.accessor(np.array([[255, 128, 0, 200]] * 4, "u1"), normalized=True),
        "JOINTS_0": parts.accessor(np.zeros((4, 4), "u1")),
        "WEIGHTS_0": parts.accessor((four * [1, 0, 0, 0]).astype("f4")),
        "_HEAT": parts.accessor(np.arange(4, dtype="f4")),
    }
    skinned["targets"] = [{"POSITION": position(parts, (four * [0, 0, 0.1]).astype("f4"))}]
    skinned["material"] = 0
    skinned["extras"] = {"part": "floor"}
    skinned["extensions"] = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}}
    wall = bounded(parts, NORMAL=normals) | {"material": 1}
    times = parts.accessor(np.array([0, 1], "f4"))
    parts.tree["accessors"][times] |= {"min": [0.0], "max": [1.0]}
    moves = parts.accessor(np.array([[0, 0, 0], [0, 0, 1]], "f4"))
    parts.tree |= {
        "meshes": [
            {"name": "floor", "primitives": [skinned], "weights": [0.0], "extras": {"targetNames": ["up"]}},
            {"name": "wall", "primitives": [wall]},
        ],
        "nodes": [
            {"name": "body", "mesh": 0, "skin": 0},
            {"name": "bone", "extras": {"twist": 0.5}},
            {
                "name": "wall",
                "mesh": 1,
                "rotation": [0.0, 0.7071067811865475, 0.0, 0.7071067811865476],
                "translation": [-1, 0, 1],
            },
            {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "eye", "camera": 0},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
        "skins": [{"joints": [1], "inverseBindMatrices": parts.accessor(np.eye(4, dtype="f4").reshape(1, 16))}],
        "animations": [
            {
                "name": "rise",
                "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                "samplers": [{"input": times, "output": moves}],
            }
        ],
        "scenes": [{"nodes": [0, 1, 2, 3, 4], "extras": {"place": "here"}}],
        "scene": 0,
    }
    whole = parts.show()
    return extended(whole, struct.pack("<I4s", 8, b"NOBY") + b"own data")


def position(parts: Parts, rows: Any) -> int:
    number = parts.accessor(rows)
    parts.tree["accessors"][number] |= {"min": rows.min(0).tolist(), "max": rows.max(0).tolist()}
    return number


def bounded(parts: Parts, **attributes: int) -> dict[str, Any]:
    return {"attributes": {"POSITION": position(parts, QUAD), **attributes}, "indices": parts.accessor(FACES)}


def extended(whole: bytes, rest: bytes) -> bytes:
    return whole[:8] + struct.pack("<I", len(whole) + len(rest)) + whole[12:] + rest


def chunks(whole: bytes) -> tuple[dict[str, Any], bytes, bytes]:
    """The JSON tree, the binary part, and what follows."""
    length = struct.unpack("<I", whole[12:16])[0]
    start = 20 + length
    size = struct.unpack("<I", whole[start : start + 4])[0]
    return json.loads(whole[20:start]), whole[start + 8 : start + 8 + size], whole[start + 8 + size :]
