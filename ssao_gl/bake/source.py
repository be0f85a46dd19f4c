"""What is baked, opened: a glTF file as it is, or anything else that is a scene, made one."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import encodable
from ..loaders.as_scene import as_scene
from ..loaders.finished import finished
from ..loaders.gltf import OPEN
from ..loaders.gltf_document import Document
from ..loaders.gltf_writing import GltfWriter
from ..loaders.load import load_scene, reading
from ..loaders.mesh_files import kind_of
from ..loaders.notes import Notes
from ..loaders.read_options import ReadOptions
from ..loaders.resolver import FolderResolver, in_folder
from ..loaders.scene_as_gltf import writer_of
from ..scene.model import Scene
from ..truth.rays import RayScene
from .facets import Facets
from .instances import separate_instances
from .primitives import Primitive, find_parts, read_primitives


@dataclass(frozen=True, eq=False)
class BakeSource:
    """A file that is to be changed, what of it is baked, and what blocks."""

    name: str
    path: Path | None
    writer: GltfWriter
    document: Document
    primitives: list[Primitive]
    facets: Facets

    @property
    def scene(self) -> Scene:
        """All that is drawn."""
        return self.facets.rays.scene


def open_source(source: Any, options: ReadOptions, *, per_instance: bool = False) -> BakeSource:
    """Read a path, or whatever :func:`ssao_gl.as_scene` takes. Raises SceneError, SettingsError.

    per_instance: every node gets a mesh of its own; else one baking serves all nodes that show a mesh.
    """
    notes = Notes()
    path = Path(source) if isinstance(source, str | Path) else None
    kept = path is not None and kind_of(path.name) in OPEN
    if path is not None and kept:
        with reading(path):
            writer = _opened(path, notes)
        name = path.name
    else:
        scene = as_scene(source) if path is None else load_scene(
            path, crease=options.crease, animation=options.animation, time=options.time, point_size=options.point_size
        )  # fmt: skip
        for line in scene.warnings:
            notes.add(line)
        writer, name = writer_of(scene), scene.name or "the scene"
        options = ReadOptions(crease=options.crease)
    with reading_from(path):
        if per_instance:
            separate_instances(writer.tree, notes)
        beside = FolderResolver((lambda name: None) if path is None else in_folder(path.parent))
        document = writer.document(beside)
        document.notes = notes
        primitives, meshes = read_primitives(document, options)
        made = finished(Scene(meshes, name=encodable(name)), notes)
    if kept:  # of others it is said by now
        notes.say(path)
    rays = RayScene(made)
    find_parts(primitives, rays)
    return BakeSource(encodable(name), path, writer, document, primitives, Facets(rays))


def reading_from(path: Path | None) -> AbstractContextManager[None]:
    """Return what makes one line of errors of a file; of a scene in memory they are its caller's."""
    return nullcontext() if path is None else reading(path)


def _opened(path: Path, notes: Notes) -> GltfWriter:
    with path.open("rb") as file:
        document = OPEN[kind_of(path.name)](file, path.stat().st_size, FolderResolver(in_folder(path.parent)))
    document.notes = notes
    return GltfWriter(document)
