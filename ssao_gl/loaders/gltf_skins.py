"""Skins of glTF: vertices as their joints stand (glTF 2.0, 3.7.3). The skinned node's own transform does not count."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.projection import Matrix
from .gltf_accessors import values
from .gltf_document import Document, Tree, index
from .gltf_nodes import local

CHUNK = 1 << 16
MAX_JOINTS = 65_536
MAX_DEPTH = 10_000


def joint_matrices(document: Document, skin: Tree, worlds: dict[int, Matrix]) -> Matrix:
    """(j, 4, 4) from the mesh to the world, for each joint of a skin."""
    joints = skin["joints"]
    if len(joints) > MAX_JOINTS:
        raise SceneError(f"has a skin of {len(joints)} joints; at most {MAX_JOINTS} are read")
    placed = np.array([_world(document, number, worlds) for number in joints]).reshape(-1, 4, 4)
    if "inverseBindMatrices" not in skin:
        return placed
    inverse = values(document, skin["inverseBindMatrices"]).astype(np.float64)
    if len(inverse) < len(placed) or inverse.shape[1] != 16:
        raise SceneError(f"has {len(inverse)} inverse bind matrices for {len(placed)} joints; it is broken")
    return placed @ inverse[: len(placed)].reshape(-1, 4, 4).transpose(0, 2, 1)


def _world(document: Document, number: Any, worlds: dict[int, Matrix]) -> Matrix:
    """Of a joint, also of one that lies outside the scene that is drawn."""
    if index(number) in worlds:
        return worlds[number]
    parents = {child: node for node, entry in enumerate(document.tree["nodes"]) for child in entry.get("children", [])}
    path = [number]
    while path[-1] in parents and path[-1] not in worlds:
        path.append(parents[path[-1]])
        if len(path) > MAX_DEPTH:
            raise SceneError(f"node {number} is its own ancestor; the nodes must form a tree")
    for node in reversed(path):
        above = worlds[parents[node]] if node in parents else np.eye(4)
        worlds.setdefault(node, above @ local(document.entry("nodes", node)))
    return worlds[number]


def skinned(
    attributes: dict[str, NDArray[Any]], joints: NDArray[Any], weights: NDArray[Any], matrices: Matrix
) -> dict[str, NDArray[Any]]:
    """Positions (n, 3), and normals where there are some, blended linearly. joints, weights: (n, 4 a set)."""
    positions, normals = attributes["POSITION"], attributes.get("NORMAL")
    if joints.shape != weights.shape or len(joints) != len(positions):
        raise SceneError(f"has joints {joints.shape} and weights {weights.shape} for {len(positions)} vertices; it is broken")
    which = np.where(weights > 0, joints, 0).astype(np.int64)
    if which.size and (which.min() < 0 or which.max() >= len(matrices)):
        raise SceneError(f"has a vertex that follows joint {int(which.max())}; there are 0 to {len(matrices) - 1}")
    made = {"POSITION": np.empty((len(positions), 3))}
    if normals is not None:
        made["NORMAL"] = np.empty((len(positions), 3), np.float32)
    for start in range(0, len(positions), CHUNK):
        part = slice(start, start + CHUNK)
        share = np.maximum(weights[part].astype(np.float64), 0)
        total = share.sum(1, keepdims=True)
        share = np.where(total > 0, share / np.where(total > 0, total, 1), 0)
        share[total[:, 0] <= 0, 0] = 1
        blended = np.zeros((len(share), 3, 4))
        for column in range(share.shape[1]):
            blended += share[:, column, None, None] * matrices[which[part, column], :3]
        made["POSITION"][part] = np.einsum("nij,nj->ni", blended[:, :, :3], positions[part]) + blended[:, :, 3]
        if normals is not None:
            x, y, z = blended[:, 0, :3], blended[:, 1, :3], blended[:, 2, :3]
            cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], 1)
            turned = np.einsum("nij,nj->ni", cofactors, normals[part])
            made["NORMAL"][part] = turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-300)
    return made
