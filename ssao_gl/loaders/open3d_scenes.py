"""Triangle meshes and point clouds of Open3D, of both of its interfaces; told by what they are, nothing of it is imported."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.material import ColorTexture, Material
from ..scene.model import Mesh, Scene
from .finished import finished
from .mesh_building import MeshData, build_mesh
from .notes import Notes
from .trimesh_scenes import CREASE
from .up_axis import up_direction

GEOMETRIES = ("TriangleMesh", "PointCloud")


def is_open3d(thing: object) -> bool:
    """Whether ``thing`` is a geometry of Open3D, or a list of some."""
    if isinstance(thing, list | tuple):
        return bool(thing) and all(map(is_open3d, thing))
    kind = type(thing)
    return kind.__module__.split(".")[0] == "open3d" and "geometry" in kind.__module__ and hasattr(thing, "get_max_bound")


def from_open3d(source: Any) -> Scene:
    """Return a ``TriangleMesh`` or ``PointCloud`` of Open3D, legacy or tensor, or a list of them, as a :class:`~ssao_gl.Scene`.

    Colours are taken for sRGB, as Open3D shows them. Raises SceneError.
    """
    notes = Notes()
    meshes: list[Mesh] = []
    for thing in source if isinstance(source, list | tuple) else [source]:
        kind = type(thing).__name__
        if kind not in GEOMETRIES:
            raise SceneError(f"cannot draw Open3D's {kind}; expected {' or '.join(GEOMETRIES)}")
        legacy = thing.to_legacy() if hasattr(thing, "to_legacy") else thing
        meshes += [_cloud(legacy)] if kind == "PointCloud" else _surfaces(legacy, notes)
    scene = finished(Scene(meshes, (), up_direction("y"), "Open3D geometry"), notes)
    notes.say(scene.name)
    return scene


def _cloud(cloud: Any) -> Mesh:
    points = np.asarray(cloud.points)
    if not len(points):
        raise SceneError("Open3D's point cloud is empty")
    colors = np.asarray(cloud.colors) if cloud.has_colors() else None
    return Mesh.from_points(points, colors, normals=np.asarray(cloud.normals) if cloud.has_normals() else None)


def _surfaces(mesh: Any, notes: Notes) -> Iterator[Mesh]:
    """Yield a mesh, or one for each of its materials where it has textures."""
    triangles = np.asarray(mesh.triangles, np.int64)
    if not len(triangles):
        raise SceneError("Open3D's mesh has no triangles")
    if mesh.has_triangle_uvs() and any(not texture.is_empty() for texture in mesh.textures):
        numbers = np.asarray(mesh.triangle_material_ids)
        numbers = numbers if len(numbers) == len(triangles) else np.zeros(len(triangles), np.int64)
        for number in np.unique(numbers):
            yield _textured(mesh, triangles, numbers == number, int(number), notes)
        return
    data = MeshData(np.asarray(mesh.vertices), triangles)
    if mesh.has_vertex_normals():
        data.normals = np.asarray(mesh.vertex_normals)
    if mesh.has_vertex_colors():
        data.colors = _bytes(np.asarray(mesh.vertex_colors))
    yield build_mesh(data, np.eye(4)[None], "", CREASE)


def _textured(mesh: Any, triangles: NDArray[np.int64], kept: NDArray[np.bool_], number: int, notes: Notes) -> Mesh:
    """The triangles of one material; their corners are not shared, as their texture coordinates are not."""
    corners = triangles[kept].ravel()
    data = MeshData(np.asarray(mesh.vertices)[corners], np.arange(len(corners)).reshape(-1, 3), soup=True)
    if mesh.has_vertex_normals():
        data.normals = np.asarray(mesh.vertex_normals)[corners]
    picture: NDArray[Any] = np.asarray(mesh.textures[number]) if number < len(mesh.textures) else np.empty(0)
    if picture.dtype == np.uint8 and picture.ndim == 3 and picture.shape[2] in (3, 4):
        # Open3D keeps pictures with their last row first, where v is 0.
        data.material = Material(base_color_texture=ColorTexture(np.ascontiguousarray(picture)))
        data.uv = np.asarray(mesh.triangle_uvs).reshape(-1, 3, 2)[kept].reshape(-1, 2)
    elif picture.size:
        notes.add(f"a texture is left out: {picture.dtype} of shape {picture.shape}; expected uint8 (h, w, 3 or 4)")
    return build_mesh(data, np.eye(4)[None], f"material {number}", CREASE)


def _bytes(colors: NDArray[np.float64]) -> NDArray[np.uint8]:
    made = np.full((len(colors), 4), 255, np.uint8)
    made[:, :3] = np.round(255 * np.clip(np.nan_to_num(colors), 0, 1))
    return made
