"""Baking: from a scene to visibility at its vertices, and to a file that keeps it."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from ..io.atomic import atomic_write, make_folder
from ..io.fingerprint import add_arrays, add_mesh
from ..loaders.gltf_writing import GltfWriter, write_glb
from ..loaders.read_options import ReadOptions
from ..settings import as_table
from ..truth.batches import TraceProgress, gather_sums
from ..truth.store import Store, store
from .fans import Fans, fans
from .settings import Baking
from .source import BakeSource, open_source
from .vertices import COLOR, write_attribute

F32 = NDArray[np.float32]
VERSION = 1
"""Part of every key of the cache: raised whenever the same input gives other numbers."""


@dataclass(frozen=True, eq=False)
class BakedMesh:
    """Visibility (n,) float32 in 0..1 of a mesh's vertices, in the order of its source; 1 where no triangle has an area."""

    name: str
    visibility: F32


@dataclass(frozen=True, eq=False)
class Baked:
    """A baked scene: its meshes in the source's order, and how they came about.

    rays: traced, in all. seconds: spent tracing them. cached: nothing was traced now. warnings: what was dropped or guessed.
    """

    name: str
    meshes: Sequence[BakedMesh]
    settings: Baking
    rays: int
    seconds: float
    cached: bool
    warnings: tuple[str, ...]
    writer: GltfWriter

    def save(self, path: Path | str) -> list[Path]:
        """Write a GLB file, or NPY files (n,) float32 of the meshes into a folder. Whole or not at all. Raises FormatError."""
        path = Path(path)
        if path.suffix.lower() == ".glb" or path == Path("-"):
            with atomic_write(path) as temporary:
                write_glb(self.writer, temporary)
            return [path]
        if path.suffix and not path.is_dir():
            raise FormatError(f"cannot write {path}: unknown suffix '{path.suffix}'; use .glb, or a folder for NPY files")
        make_folder(path)
        return [_save_array(path, k, mesh) for k, mesh in enumerate(self.meshes)]


def _save_array(folder: Path, number: int, mesh: BakedMesh) -> Path:
    name = re.sub(r"[^\w.-]+", "_", mesh.name)[:80]
    path = folder / f"{number:03d}-{name}.npy"
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        np.save(file, mesh.visibility)
    return path


def bake(
    scene: Any,
    settings: Baking | None = None,
    *,
    attribute: str = COLOR,
    per_instance: bool = False,
    animation: str | None = None,
    time: float = 0.0,
    cache: Path | None = None,
    progress: TraceProgress | None = None,
) -> Baked:
    """Trace ambient occlusion at the vertices of a scene, to be kept in a file. No OpenGL is needed.

    scene: a path, a :class:`~ssao_gl.Scene`, a ``trimesh`` mesh or scene. attribute: COLOR_0, whose colours are multiplied, or
    a name that begins with an underscore. per_instance: a mesh for each node that shows one; else all nodes show the mean
    over them. animation, time: the pose, see :func:`ssao_gl.load_scene`. cache: a folder where what is traced is kept, and
    from where an interrupted run goes on. Raises SceneError, SettingsError, FormatError.
    """
    check_attribute(attribute)
    source = open_source(scene, ReadOptions(animation=animation, time=time), per_instance=per_instance)
    settings = (settings or Baking()).with_radius(source.scene.default_radius())
    places, owners = fans(source.rays, source.primitives, settings.points, settings.seed)
    found = traced(source, places, settings, cache, progress)
    meshes = []
    for primitive, own in zip(source.primitives, owners, strict=True):
        visibility = np.append(found.visibility, 1.0)[own].astype(np.float32)  # -1: the last
        meshes.append(BakedMesh(primitive.name, visibility))
        if primitive.parts:
            write_attribute(source.writer, source.document, primitive, visibility, attribute)
    rays = len(places) * settings.batches[0] * settings.batches[1] * (2 if settings.sides == "both" else 1)
    return Baked(source.name, meshes, settings, rays, found.seconds, found.cached, source.document.notes.lines, source.writer)


@dataclass(frozen=True, eq=False)
class TracedPlaces:
    """Visibility (n,) of places, and the time that tracing took."""

    visibility: NDArray[np.float64]
    seconds: float
    cached: bool


def traced(
    source: BakeSource, places: Fans, settings: Baking, cache: Path | None, progress: TraceProgress | None
) -> TracedPlaces:
    """Trace places on the sides that count; take what is in the cache from there."""
    sides = (1.0, -1.0) if settings.sides == "both" else (1.0,)
    found = [_side(source, replace(places, side=side), settings, cache, progress) for side in sides]
    visibility = np.max([one.visibility for one in found], axis=0)
    return TracedPlaces(visibility, sum(one.seconds for one in found), all(one.cached for one in found))


def _side(
    source: BakeSource, places: Fans, settings: Baking, cache: Path | None, progress: TraceProgress | None
) -> TracedPlaces:
    kept: Store | None = None
    if cache is not None:
        kept = store(cache, _key(source, places, settings), "bake")
        done = kept.result()
        if done is not None:
            return TracedPlaces(done["visibility"], float(done["seconds"]), True)
    sums = gather_sums(places, settings, kept=kept, progress=progress)
    visibility = np.clip(sums.estimate()[0], 0, 1)
    if kept is not None:
        kept.finish({"visibility": visibility, "seconds": sums.seconds})
    return TracedPlaces(visibility, sums.seconds, False)


def _key(source: BakeSource, places: Fans, settings: Baking) -> str:
    """Hash of all that decides the numbers."""
    digest = hashlib.sha256(json.dumps([VERSION, as_table(settings), places.side], sort_keys=True).encode())
    for mesh in source.scene.drawn:
        add_mesh(digest, mesh, normals=True, colors=False)
    add_arrays(digest, (places.primitive, places.triangle, places.corner, places.reach, places.places))
    add_arrays(digest, (np.array(p.parts) for p in places.primitives))
    return digest.hexdigest()[:32]


def check_attribute(name: str) -> None:
    """Raise FormatError for a name that glTF does not let one give to an attribute of one's own (glTF 2.0, 3.7.2.1)."""
    if name != COLOR and not re.fullmatch(r"_[A-Z0-9_]+", name):
        raise FormatError(f"attribute '{name}': must be {COLOR}, or begin with _ and have capitals and digits, like _AO")
