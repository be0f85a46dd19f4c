"""What is baked: the primitives of a glTF document in its own vertices, and what blocks their light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..loaders.gltf import Shape, broken_structure, check_any, read_shapes
from ..loaders.gltf_document import Document, Tree
from ..loaders.mesh_building import MeshData
from ..loaders.read_options import ReadOptions
from ..scene.model import Mesh
from ..truth.rays import RayScene

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]


@dataclass(eq=False)
class Primitive:
    """A primitive of a mesh of the file.

    faces: (m, 3) in its own vertices, of which there are ``len(data.vertices)``. meshes: what is drawn of it, one for each
    shape in which nodes show it, with the same triangles in the same order. parts: their numbers in the
    :class:`~ssao_gl.truth.rays.RayScene`, one for each instance of each shape; none where all of it is cut out.
    """

    mesh: int
    number: int
    name: str
    data: MeshData
    meshes: list[Mesh] = field(default_factory=list)
    parts: list[int] = field(default_factory=list)

    @property
    def faces(self) -> I64:
        return np.asarray(self.data.faces, np.int64)

    @property
    def double_sided(self) -> bool:
        """Whether its material is seen from behind, too."""
        return self.data.material is not None and self.data.material.double_sided

    def entry(self, tree: Tree) -> Tree:
        """Return what the tree says of it."""
        found: Tree = tree["meshes"][self.mesh]["primitives"][self.number]
        return found

    @property
    def vertices(self) -> int:
        """How many there are."""
        return len(self.data.vertices)


def read_primitives(document: Document, options: ReadOptions) -> tuple[list[Primitive], list[Mesh]]:
    """Return what is baked, in the file's order, and all that is drawn. Raises SceneError."""
    found: dict[tuple[int, int], Primitive] = {}
    drawn: list[Mesh] = []
    points = 0
    with broken_structure():
        for shape in read_shapes(document, options)[0]:
            made = shape.built(options)
            drawn += made
            if shape.points:
                points += 1
            elif made:
                _join(found, shape).meshes += made
    check_any(document, drawn)
    if points:
        document.notes.add("points block light, and are not baked themselves")
    if not found:
        raise SceneError("holds no triangles, only points; there is nothing to bake")
    return [found[key] for key in sorted(found)], drawn


def _join(found: dict[tuple[int, int], Primitive], shape: Shape) -> Primitive:
    key = (shape.mesh, shape.primitive)
    if key not in found:
        found[key] = Primitive(*key, shape.name, shape.data)
    return found[key]


def find_parts(primitives: list[Primitive], rays: RayScene) -> None:
    """Fill in which parts of ``rays`` show each primitive."""
    numbers: dict[int, range] = {}
    start = 0
    for mesh in rays.scene.drawn:
        numbers[id(mesh)] = range(start, start + len(mesh.transforms))
        start += len(mesh.transforms)
    for primitive in primitives:
        primitive.parts = [part for mesh in primitive.meshes for part in numbers.get(id(mesh), ())]


def chosen_parts(primitives: Sequence[Primitive], which: NDArray[np.integer], choice: F64) -> I64:
    """Return a part (n,) of each primitive ``which`` (n,), evenly by ``choice`` (n,) in [0, 1)."""
    parts = np.empty(len(which), np.int64)
    for number in np.unique(which) if len(which) and which.min() < which.max() else which[:1]:
        of = np.flatnonzero(which == number)
        every = np.array(primitives[number].parts)
        parts[of] = every[np.minimum((choice[of] * len(every)).astype(np.int64), len(every) - 1)]
    return parts
