"""Meshes and scenes of trimesh."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, one_line
from ..scene.camera import Camera
from ..scene.lens import Perspective
from ..scene.model import Mesh, Scene
from .finished import finished
from .mesh_building import MeshData, build_mesh
from .notes import Notes
from .read_options import ReadOptions
from .trimesh_materials import TrimeshLooks
from .up_axis import Direction, up_direction

if TYPE_CHECKING:
    import trimesh

CREASE = math.radians(40)


def from_trimesh(
    source: trimesh.Trimesh | trimesh.PointCloud | trimesh.Scene,
    *,
    crease: float = CREASE,
    up: Direction | None = None,
    name: str = "",
    weld_vertices: bool = False,
    point_size: float | None = None,
) -> Scene:
    """Return a :class:`~ssao_gl.Scene` from a ``trimesh.Trimesh``, ``PointCloud`` or ``Scene``; instances share one geometry.

    up: which way automatic views take for upwards; None: the z axis for what trimesh read from a file in a format where that is
    usual (STL, PLY, OFF), else the y axis. weld_vertices: vertices at the same place become one where normals must be made, so that they are smooth. point_size: of
    points, scene units; None for one that closes their surface. Raises SceneError.
    """
    import trimesh

    kind = str(getattr(getattr(source, "source", None), "file_type", None) or "")
    if isinstance(source, trimesh.Trimesh | trimesh.PointCloud):
        source = trimesh.Scene(source)
    if not isinstance(source, trimesh.Scene):
        raise SceneError(f"expected a trimesh.Trimesh or trimesh.Scene, got {type(source).__name__}")
    notes = Notes()
    meshes = meshes_of(source, ReadOptions(crease=crease, point_size=point_size), notes, soup=weld_vertices)
    scene = finished(Scene(meshes, _cameras(source, notes), up or up_direction("auto", kind), name), notes)
    notes.say(name or "the trimesh scene")
    return scene


def is_trimesh(thing: object) -> bool:
    """Whether ``thing`` is trimesh's; does not import it."""
    return any(kind.__module__.split(".")[0] == "trimesh" for kind in type(thing).__mro__)


def viewer_camera(scene: trimesh.Scene) -> Camera:
    """Return the camera that ``scene.show()`` starts with, or had when it was closed: the scene's own, else the one trimesh makes.

    That one has no far plane here; trimesh's, at 1000 units, cuts large scenes. Raises SceneError.
    """
    if not hasattr(type(scene), "camera_transform"):  # of the type: to ask a scene for its camera gives it one
        raise SceneError(f"camera: a trimesh.{type(scene).__name__} has none; put it into a trimesh.Scene")
    notes = Notes()
    if scene.has_camera:
        found = _cameras(scene, notes)
        if not found:
            raise SceneError("camera: " + "; ".join(notes.lines))
        return found[0]
    copied = scene.copy()
    lens = Perspective(math.radians(float(copied.camera.fov[1])), 1e-4 * float(copied.scale or 1), None)
    return Camera(lens, np.asarray(copied.camera_transform, np.float64), "trimesh")


def meshes_of(
    source: trimesh.Scene, options: ReadOptions, notes: Notes, *, soup: bool, looks: TrimeshLooks | None = None
) -> list[Mesh]:
    """Return everything that can be drawn of a ``trimesh.Scene``. Raises SceneError when there is nothing.

    ``looks``: the reader of its materials, where it must know more.
    """
    import trimesh

    places: dict[str, list[NDArray[np.float64]]] = {}
    for node in source.graph.nodes_geometry:
        matrix, geometry = source.graph.get(node)
        places.setdefault(str(geometry), []).append(np.asarray(matrix, np.float64))
    looks = looks or TrimeshLooks(notes)
    made: list[Mesh] = []
    dropped: set[str] = set()
    for key, found in places.items():
        geometry = source.geometry.get(key)
        transforms = np.stack(found)
        if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces):
            data = MeshData(np.asarray(geometry.vertices), np.asarray(geometry.faces), soup=soup)
            if "vertex_normals" in geometry._cache:  # read from the file, not computed by trimesh
                data.normals = np.asarray(geometry.vertex_normals)
            looks.paint(data, geometry, key)
            made.append(build_mesh(data, transforms, key, options.crease))
        elif isinstance(geometry, trimesh.PointCloud) and len(geometry.vertices):
            made += [_points(geometry, matrix, key, options) for matrix in transforms]
        else:
            dropped.add("empty meshes" if isinstance(geometry, trimesh.Trimesh) else type(geometry).__name__)
    if not made:
        kinds = sorted(dropped - {"empty meshes"})
        raise SceneError("holds no triangles" + (f", only {', '.join(kinds)}" if kinds else ""))
    for kind in sorted(dropped - {"empty meshes"}):
        notes.add(f"drawn without what is no mesh and no points: {kind}")
    return made


def _points(cloud: Any, matrix: NDArray[np.float64], name: str, options: ReadOptions) -> Mesh:
    world = np.asarray(cloud.vertices, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    colors: Any = np.asarray(cloud.colors) if cloud.visual is not None else None
    usable = colors is not None and colors.shape == (len(world), 4) and colors.dtype == np.uint8
    return Mesh.from_points(world, colors if usable else None, options.point_radius, name=name)


def _cameras(source: Any, notes: Notes) -> list[Camera]:
    """The scene's own camera; trimesh keeps one, with a field of view in degrees (x, y)."""
    if not source.has_camera:
        return []
    camera = source.camera
    far = float(camera.z_far) if camera.z_far else None
    try:
        lens = Perspective(math.radians(float(camera.fov[1])), max(float(camera.z_near), 1e-9), far)
        return [Camera(lens, np.asarray(source.camera_transform, np.float64), camera.name or "file")]
    except Exception as error:
        notes.add(f"the file's camera is unusable: {one_line(error)}")
        return []
