"""The nodes of a glTF file: flattened to one a mesh, with its transform to the world, and the cameras taken out.

trimesh follows deep trees in quadratic time, names instances at random, and keeps one camera, without the transforms
above it.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import SceneError, one_line
from ..scene.camera import Camera, Orthographic, Perspective
from ..scene.projection import Matrix

Tree = dict[str, Any]

MAX_CAMERAS = 1000

Placed = tuple[int, Matrix]
"""The number of a mesh, and its transform to the world."""


def index(value: Any) -> int:
    """A reference: Python would take -1 for the last."""
    if not isinstance(value, int) or value < 0:
        raise IndexError(f"{value!r} is no index")
    return value


def flatten(tree: Tree) -> tuple[list[Placed], list[Camera]]:
    """Meshes where they stand in the world, and the cameras. Raises SceneError for what is no tree."""
    nodes = tree.get("nodes", [])
    placed: list[Placed] = []
    cameras: list[Camera] = []
    seen, seen_cameras = set(), 0
    stack = [(root, np.eye(4)) for root in reversed(_roots(tree, nodes))]
    while stack:
        number, above = stack.pop()
        node = nodes[index(number)]
        if number in seen:
            raise SceneError(f"node {number} has two parents or is its own ancestor; the nodes must form a tree")
        seen.add(number)
        world = above @ local(node)
        if "mesh" in node:
            mesh = tree["meshes"][index(node["mesh"])]
            mesh.setdefault("name", node.get("name") or f"mesh {node['mesh']}")
            placed.append((node["mesh"], world))
        if "camera" in node:
            seen_cameras += 1
            if seen_cameras > MAX_CAMERAS:
                raise SceneError(f"has more than {MAX_CAMERAS} cameras; it is broken")
            cameras += _camera(tree["cameras"][index(node["camera"])], world, str(node.get("name") or ""), len(cameras))
        stack += [(child, world) for child in reversed(node.get("children", []))]
    return placed, cameras


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
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = np.asarray(node["rotation"], np.float64) / (np.linalg.norm(node["rotation"]) or 1.0)
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    matrix[:3, :3] *= np.asarray(node.get("scale", (1, 1, 1)), np.float64)
    matrix[:3, 3] = np.asarray(node.get("translation", (0, 0, 0)), np.float64)
    return matrix


def _camera(entry: Mapping[str, Any], world: Matrix, node: str, number: int) -> list[Camera]:
    """The camera, or nothing and a warning when it cannot be used: the scene can still be seen without."""
    name = node or str(entry.get("name") or f"camera {number}")
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
        pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)  # a camera has no size
        if not math.isclose(abs(np.linalg.det(pose[:3, :3])), 1, abs_tol=1e-3):
            raise ValueError("its axes are not at right angles")
        return [Camera(lens, pose, name)]
    except Exception as error:
        logging.getLogger("ssao_gl").warning("the file's camera '%s' is unusable: %s", one_line(name, 50), one_line(error))
        return []
