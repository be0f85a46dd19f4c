"""Baking: from a scene to visibility at its vertices, and to a file that keeps it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, SettingsError, near_miss
from ..io.atomic import atomic_write, make_folder
from ..loaders.gltf_writing import GltfWriter, write_glb
from ..loaders.read_options import ReadOptions
from ..scene.model import RADIUS_SHARE
from ..truth.batches import TraceProgress
from .elements import Elements, elements
from .fans import fans
from .gathering import TracedPlaces, trace_places
from .settings import Baking, OcclusionTexture, Vertices
from .source import BakeSource, open_source, reading_from
from .textures import texture_groups, write_texture
from .vertices import write_attribute

F32 = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class BakedMesh:
    """Visibility in 0..1, float32: (n,) of a mesh's vertices, in the order of its source, 1 where no triangle has an area; or
    (size, size) of a texture, row 0 on top."""

    name: str
    visibility: F32
    indirect: F32 | None = None
    """(n, 3) linear light that arrives at vertices from other surfaces under a sky of 1; None where nobody asked."""


@dataclass(frozen=True, eq=False)
class Baked:
    """A baked scene: its meshes in the source's order, or its textures, and how they came about.

    rays: traced, in all. seconds: spent tracing them, or by elements. cached: nothing was traced now. warnings: what was dropped or guessed.
    """

    name: str
    meshes: Sequence[BakedMesh]
    settings: Baking
    to: Vertices | OcclusionTexture
    rays: int
    seconds: float
    cached: bool
    warnings: tuple[str, ...]
    writer: GltfWriter

    def save(self, path: Path | str) -> list[Path]:
        """Write a GLB file, or NPY files of the meshes or textures into a folder. Whole or not at all. Raises FormatError."""
        path = Path(path)
        if path.suffix.lower() == ".glb" or path == Path("-"):
            with atomic_write(path) as temporary:
                write_glb(self.writer, temporary)
            return [path]
        if path.suffix and not path.is_dir():
            raise FormatError(f"cannot write {path}: unknown suffix '{path.suffix}'; use .glb, or a folder for NPY files")
        make_folder(path)
        return [written for k, mesh in enumerate(self.meshes) for written in _save_arrays(path, k, mesh)]


def _save_arrays(folder: Path, number: int, mesh: BakedMesh) -> Iterator[Path]:
    name = re.sub(r"[^\w.-]+", "_", mesh.name)[:80]
    for ending, values in (("", mesh.visibility), ("-indirect", mesh.indirect)):
        if values is not None:
            path = folder / f"{number:03d}-{name}{ending}.npy"
            with atomic_write(path) as temporary, temporary.open("wb") as file:
                np.save(file, values)
            yield path


def bake(
    scene: Any,
    settings: Baking | None = None,
    *,
    to: Vertices | OcclusionTexture | str = "vertices",
    radius_share: float | None = None,
    per_instance: bool = False,
    animation: str | None = None,
    time: float = 0.0,
    cache: Path | None = None,
    progress: TraceProgress | None = None,
) -> Baked:
    """Trace ambient occlusion of a scene's surface, to be kept in a file. No OpenGL is needed.

    scene: a path, a :class:`~ssao_gl.Scene`, a ``trimesh`` mesh or scene. to: vertices or texture, or a record that says more.
    radius_share: of the scene's size, where ``settings`` leave the radius open. per_instance: a mesh for each node that
    shows one; else all nodes show the mean over them. animation, time: the pose, see :func:`ssao_gl.load_scene`. cache: a
    folder where what is traced is kept, and from where an interrupted run goes on. Raises SceneError, SettingsError,
    FormatError.
    """
    goal = _goal(to)
    if settings is not None and settings.indirect and goal != Vertices():
        raise SettingsError(
            "indirect: is light in colours, which COLOR_0 of vertices keeps; leave out --to texture and --attribute"
        )
    source = open_source(scene, ReadOptions(animation=animation, time=time), per_instance=per_instance)
    share = RADIUS_SHARE if radius_share is None else radius_share
    settings = (settings or Baking()).with_radius(source.scene.default_radius(share))
    job = _Job(source, settings, cache, progress)
    with reading_from(source.path):
        meshes, traced = job.vertices(goal) if isinstance(goal, Vertices) else job.textures(goal)
    return Baked(
        source.name, meshes, settings, goal,
        sum(one.rays for one in traced), job.preparing + sum(one.seconds for one in traced), all(one.cached for one in traced),
        source.document.notes.lines, source.writer,
    )  # fmt: skip


def _goal(to: Vertices | OcclusionTexture | str) -> Vertices | OcclusionTexture:
    if not isinstance(to, str):
        return to
    known: dict[str, type[Vertices] | type[OcclusionTexture]] = {kind.name: kind for kind in (Vertices, OcclusionTexture)}
    if to not in known:
        raise SettingsError(f"bake to '{to}': must be vertices or texture.{near_miss(to, known)}")
    return known[to]()


@dataclass(frozen=True, eq=False)
class _Job:
    source: BakeSource
    settings: Baking
    cache: Path | None
    progress: TraceProgress | None

    @property
    def preparing(self) -> float:
        """Seconds that the disks took."""
        return self.elements.seconds if self.elements is not None else 0.0

    @cached_property
    def elements(self) -> Elements | None:
        """The scene's disks, where these measure."""
        return elements(self.source.facets.rays, self.settings) if self.settings.by == "elements" else None

    def vertices(self, goal: Vertices) -> tuple[list[BakedMesh], list[TracedPlaces]]:
        source, settings = self.source, self.settings
        places, owners = fans(source.facets, source.primitives, settings.points, settings.seed)
        traced = trace_places(source.scene, places, settings, self.cache, self.progress, self.elements)
        meshes = []
        for primitive, own in zip(source.primitives, owners, strict=True):
            visibility = np.append(traced.visibility, 1.0)[own].astype(np.float32)  # -1: the last
            indirect = (
                np.append(traced.indirect, 0 * traced.indirect[:1], 0)[own].astype(np.float32) if settings.indirect else None
            )
            meshes.append(BakedMesh(primitive.name, visibility, indirect))
            if primitive.parts:
                write_attribute(source.writer, source.document, primitive, visibility, goal.attribute, indirect)
        return meshes, [traced]

    def textures(self, goal: OcclusionTexture) -> tuple[list[BakedMesh], list[TracedPlaces]]:
        source = self.source
        meshes, done = [], []
        groups = texture_groups(source.writer, source.document, source.facets, source.primitives, goal, self.settings.seed)
        for group in groups:
            traced = trace_places(source.scene, group.places, self.settings, self.cache, self.progress, self.elements)
            meshes.append(BakedMesh(group.name, write_texture(source.writer, source.document, group, traced.visibility)))
            done.append(traced)
        return meshes, done
