"""Meshes that several nodes show, made one for each node."""

from __future__ import annotations

import copy

from ..loaders.gltf_document import Tree, index
from ..loaders.gltf_nodes import INSTANCING
from ..loaders.notes import Notes


def separate_instances(tree: Tree, notes: Notes) -> None:
    """Give every node a mesh of its own. The copies name the same accessors, so only what is baked takes more bytes."""
    taken: set[int] = set()
    many = 0
    for node in tree.get("nodes", []):
        if "mesh" not in node:
            continue
        many += INSTANCING in node.get("extensions", {})
        number = index(node["mesh"])
        if number in taken:
            tree["meshes"].append(copy.deepcopy(tree["meshes"][number]))
            node["mesh"] = len(tree["meshes"]) - 1
        taken.add(number)
    if many:
        notes.add(f"{many} nodes draw many copies each ({INSTANCING}), which cannot be told apart: they get their mean")
