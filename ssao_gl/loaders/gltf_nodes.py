"""The nodes of a glTF file: one placement a mesh, with its transforms to the world, and the cameras (glTF 2.0, 3.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import SceneError, encodable, one_line
from ..scene.camera import Camera
from ..scene.lens import Orthographic, Perspective
from ..scene.projection import Matrix
from .gltf_accessors import values
from .gltf_document import Document, Tree, index

MAX_CAMERAS = 1000
MAX_INSTANCES = 100_000
"""Nodes that place a mesh."""
INSTANCING, VISIBILITY = "EXT_mesh_gpu_instancing", "KHR_node_visibility"


@dataclass(frozen=True)
class Placed:
    """A mesh where a node stands: its number, (k, 4, 4) transforms to the world, and the node."""

    mesh: int
    transforms: Matrix
    node: Tree


def flatten(document: Document) -> tuple[list[Placed], list[Camera], dict[int, Matrix]]:
    """Meshes where they stand, the cameras, and each node's transform to the world. Raises SceneError for what is no tree."""
    tree, nodes = document.tree, document.tree.get("nodes", [])
    placed: list[Placed] = []
    cameras: list[Camera] = []
    worlds: dict[int, Matrix] = {}
    seen_cameras = 0
    stack = [(root, np.eye(4), True) for root in reversed(_roots(tree, nodes))]
    while stack:
        number, above, visible = stack.pop()
        node = nodes[index(number)]
        if number in worlds:
            raise SceneError(f"node {number} has two parents or is its own ancestor; the nodes must form a tree")
        world = worlds[number] = above @ local(node)
        visible = visible and bool(node.get("extensions", {}).get(VISIBILITY, {}).get("visible", True))
        if "mesh" in node and visible:
            tree["meshes"][index(node["mesh"])]
            placed.append(Placed(node["mesh"], _instances(document, node, world), node))
            if len(placed) > MAX_INSTANCES:
                raise SceneError(f"draws more than {MAX_INSTANCES} nodes with meshes, which is too much; merge them")
        if "camera" in node:
            seen_cameras += 1
            if seen_cameras > MAX_CAMERAS:
                raise SceneError(f"has more than {MAX_CAMERAS} cameras; it is broken")
            cameras += _camera(document, node, world, len(cameras))
        stack += [(child, world, visible) for child in reversed(node.get("children", []))]
    return placed, cameras, worlds


def _roots(tree: Tree, nodes: list[Any]) -> list[int]:
    """Of the file's scene; without any scene, all nodes that are nobody's child."""
    if tree.get("scenes"):
        return list(tree["scenes"][index(tree.get("scene", 0))].get("nodes", []))
    children = {child for node in nodes for child in node.get("children", [])}
    return [number for number in range(len(nodes)) if number not in children]


def local(node: Mapping[str, Any]) -> Matrix:
    """A node's transform to its parent: a matrix, or translation x rotation x scale."""
    if "matrix" in node:
        return np.asarray(node["matrix"], np.float64).reshape(4, 4).T
    made = {key: np.asarray(node[key], np.float64)[None] for key in ("translation", "rotation", "scale") if key in node}
    placed: Matrix = transforms(1, **made)[0]
    return placed


def transforms(
    count: int, translation: Matrix | None = None, rotation: Matrix | None = None, scale: Matrix | None = None
) -> Matrix:
    """(count, 4, 4) translation x rotation x scale of rows of numbers; quaternions are x, y, z, w of any length."""
    matrix = np.tile(np.eye(4), (count, 1, 1))
    if rotation is not None:
        length = np.linalg.norm(rotation, axis=1, keepdims=True)
        x, y, z, w = (rotation / np.where(length > 0, length, 1)).T
        matrix[:, :3, :3] = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        ).transpose(2, 0, 1)
    if scale is not None:
        matrix[:, :3, :3] *= scale.reshape(count, 1, 3)
    if translation is not None:
        matrix[:, :3, 3] = translation
    return matrix


def _instances(document: Document, node: Tree, world: Matrix) -> Matrix:
    """(k, 4, 4): one, or those of EXT_mesh_gpu_instancing."""
    many = node.get("extensions", {}).get(INSTANCING)
    if many is None:
        return world[None]
    names = [name for name in ("TRANSLATION", "ROTATION", "SCALE") if name in many["attributes"]]
    rows = {name.lower(): values(document, many["attributes"][name], name).astype(np.float64) for name in names}
    count = min((len(row) for row in rows.values()), default=1)
    document.take(count * 256)
    placed: Matrix = world @ transforms(count, **{name: row[:count] for name, row in rows.items()})
    return placed


def _camera(document: Document, node: Tree, world: Matrix, number: int) -> list[Camera]:
    """The camera, or nothing and a note when it cannot be used: the scene can still be seen without."""
    entry = document.tree["cameras"][index(node["camera"])]
    name = encodable(str(node.get("name") or "") or str(entry.get("name") or f"camera {number}"))
    try:
        lens: Any
        if entry["type"] == "perspective":
            facts = entry["perspective"]
            far = facts.get("zfar")
            lens = Perspective(float(facts["yfov"]), float(facts["znear"]), None if far is None else float(far))
        else:
            facts = entry["orthographic"]
            lens = Orthographic(2 * float(facts["ymag"]), float(facts["znear"]), float(facts["zfar"]))
        pose = world.copy()
        pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)  # a camera has no size,
        pose[:3, 0] *= np.sign(np.linalg.det(pose[:3, :3]))  # and does not mirror
        if not math.isclose(abs(np.linalg.det(pose[:3, :3])), 1, abs_tol=1e-3):
            raise ValueError("its axes are not at right angles")
        return [Camera(lens, pose, name)]
    except Exception as error:
        document.notes.add(f"the file's camera '{one_line(name, 50)}' is unusable: {one_line(error)}")
        return []
