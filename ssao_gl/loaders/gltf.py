"""glTF 2.0 files: what is drawn of them, as meshes and cameras. Parts that are not drawn are never unpacked.

Specification: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator, Sized
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import SceneError
from ..scene.camera import Camera
from ..scene.lamps import Lamp
from ..scene.model import Mesh
from ..scene.projection import Matrix
from .gltf_animation import pose
from .gltf_document import Document, Tree, index, open_glb, open_gltf
from .gltf_extensions import check_extensions
from .gltf_lamps import lamps_of
from .gltf_materials import Materials
from .gltf_nodes import Placed, flatten
from .gltf_primitives import MODES, POINTS, primitive_data
from .mesh_building import MeshData, build_mesh
from .read_options import ReadOptions

OPEN = {"glb": open_glb, "gltf": open_gltf}
MAX_PRIMITIVES = 10_000
MAX_PLACED = 100_000
"""Primitives at all their nodes."""


@dataclass(frozen=True)
class Shape:
    """A primitive in one of the shapes that it takes, and (k, 4, 4) where it stands. ``points``: it has no triangles."""

    mesh: int
    primitive: int
    name: str
    data: MeshData
    transforms: Matrix
    points: bool

    def built(self, options: ReadOptions) -> list[Mesh]:
        """Return what is drawn of it. Raises SceneError."""
        if self.points:
            return [_points(self.data, m, self.name, options) for m in self.transforms if len(self.data.vertices)]
        drawn = len(self.data.faces) and len(self.transforms)
        return [build_mesh(self.data, self.transforms, self.name, options.crease)] if drawn else []


def read_gltf(document: Document, options: ReadOptions) -> tuple[list[Mesh], list[Camera], list[Lamp]]:
    """Meshes, cameras and lamps of a document. Raises SceneError."""
    with broken_structure():
        shapes, cameras, lamps = read_shapes(document, options)
        made = [mesh for shape in shapes for mesh in shape.built(options)]
    check_any(document, made)
    return made, cameras, lamps


def read_shapes(document: Document, options: ReadOptions) -> tuple[Iterator[Shape], list[Camera], list[Lamp]]:
    """Primitives in the shapes that they take, made one after another, cameras and lamps. Raises SceneError, and what a broken
    structure leads to (see :func:`broken_structure`)."""
    check_extensions(document)
    if options.animation is not None:
        pose(document, options.animation, options.time)
    placed, cameras, worlds = flatten(document)
    return _made(document, placed, worlds), cameras, lamps_of(document, worlds)


@contextmanager
def broken_structure() -> Iterator[None]:
    """Turn what a broken document leads Python into to a SceneError."""
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise SceneError(f"its glTF structure is broken ({type(error).__name__}: {error})") from error


def check_any(document: Document, made: Sized) -> None:
    """Raise SceneError when nothing of a document can be drawn."""
    if not len(made):
        with broken_structure():
            lines = any(mesh["primitives"] for mesh in document.tree.get("meshes", []))
        raise SceneError("holds no triangles" + (", only lines or what has no size" if lines else ""))


def _made(document: Document, placed: list[Placed], worlds: dict[int, Matrix]) -> Iterator[Shape]:
    """One for each primitive in each shape that it takes; nodes that show the same become instances."""
    materials = Materials(document)
    names: Counter[str] = Counter()
    for (mesh, number, *_), nodes in _shapes(document, placed).items():
        entry = document.entry("meshes", mesh)
        primitive = entry["primitives"][number]
        node = nodes[0].node
        weights = [float(weight) for weight in node.get("weights") or entry.get("weights") or []]
        skin = document.entry("skins", node["skin"]) if "skin" in node and _has_joints(primitive) else None
        data = primitive_data(document, materials, primitive, weights, skin, worlds)
        name = str(entry.get("name") or node.get("name") or f"mesh {mesh}")[:200]
        names[name] += 1
        name = name if names[name] == 1 else f"{name}_{names[name] - 1}"
        transforms = np.eye(4)[None] if skin is not None else np.concatenate([each.transforms for each in nodes])
        yield Shape(mesh, number, name, data, transforms, primitive.get("mode") == POINTS)


def _shapes(document: Document, placed: list[Placed]) -> dict[tuple[Any, ...], list[Placed]]:
    """(mesh, primitive, weights and skin where it has some) -> where it stands."""
    shapes: dict[tuple[Any, ...], list[Placed]] = {}
    total, dropped = 0, 0
    for each in reversed(placed):  # as before version 0.2: truth that was stored then is still found
        primitives = document.entry("meshes", each.mesh)["primitives"]
        moving = tuple(each.node["weights"]) if "weights" in each.node else None
        for number, primitive in reversed(list(enumerate(primitives))):
            if primitive.get("mode", 4) not in MODES:
                dropped += 1
                continue
            skin = (index(each.node["skin"]),) if "skin" in each.node and _has_joints(primitive) else ()
            shapes.setdefault((each.mesh, number, moving, skin), []).append(each)
            total += 1
            if len(shapes) > MAX_PRIMITIVES or total > MAX_PLACED:
                raise SceneError(
                    f"draws more than {MAX_PRIMITIVES} primitives, or {MAX_PLACED} instances of them, which is too much; merge them"
                )
    if dropped and shapes:
        document.notes.add("drawn without its lines")
    return shapes


def _has_joints(primitive: Tree) -> bool:
    return "JOINTS_0" in primitive["attributes"]


def _points(data: MeshData, transform: Matrix, name: str, options: ReadOptions) -> Mesh:
    """Points in the world, so that their size is meant there too."""
    world = data.vertices.astype(np.float64) @ transform[:3, :3].T + transform[:3, 3]
    normals = None if data.normals is None else data.normals @ np.linalg.pinv(transform[:3, :3])
    mesh = Mesh.from_points(world, data.colors, options.point_radius, normals=normals, name=name)
    if data.material is None:
        return mesh
    return dataclasses.replace(mesh, material=data.material)
