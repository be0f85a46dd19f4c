"""Scenes and cameras from whatever a caller has."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SceneError, SettingsError
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..scene.volume import Volume
from . import open3d_scenes, pyrender_scenes, pyvista_scenes
from .camera_files import load_camera
from .camera_objects import camera_of
from .load import load_scene
from .trimesh_scenes import from_trimesh, is_trimesh, viewer_camera
from .up_axis import up_direction


def as_scene(source: Any, up: str = "auto") -> Scene:
    """A scene from a path, a ``trimesh.Trimesh`` or ``Scene``, a ``pyrender.Scene``, a plotter or data set of PyVista, meshes and point clouds of Open3D, points (n, 3), a :class:`Volume`, or itself. Raises SceneError.

    up: axis that automatic views take for upwards, x, y or z; auto: the source's own, or that of its file's format.
    """
    direction = up_direction(up)
    scene = _scene(source)
    return scene if up == "auto" else dataclasses.replace(scene, up=direction)


def _scene(source: Any) -> Scene:
    if isinstance(source, Scene):
        return source
    if isinstance(source, Volume):
        return Scene(up=up_direction("z"), name=source.name, volumes=[source])
    if isinstance(source, np.ndarray) and type(source).__module__ == "numpy":
        return Scene.from_points(source)
    if isinstance(source, str | Path):
        return load_scene(source)
    if pyrender_scenes.is_pyrender_scene(source):
        return pyrender_scenes.from_pyrender(source)
    if pyvista_scenes.is_pyvista(source):
        return pyvista_scenes.from_pyvista(source)
    if open3d_scenes.is_open3d(source):
        return open3d_scenes.from_open3d(source)
    if is_trimesh(source):
        return from_trimesh(source)
    raise SceneError(
        f"cannot draw a {type(source).__name__}; expected a path, Scene, Volume, trimesh.Trimesh, trimesh.Scene, pyrender.Scene, pyvista.Plotter or data set, open3d.geometry.TriangleMesh or PointCloud, or points (n, 3)"
    )


def as_camera(source: Any, size: Size | None = None) -> Camera:
    """A camera from a camera file (``"FILE:NAME"``), a ``pyrender.Scene`` with a camera, a ``trimesh.Scene``, a camera of another library, or itself.

    size: (width, height) of the image, for what does not say. See :func:`.camera_objects.camera_of` and
    :func:`.camera_files.load_cameras` for what is known. Raises SettingsError, SceneError.
    """
    if isinstance(source, Camera):
        return source
    if isinstance(source, str | Path):
        return load_camera(str(source), size)
    if pyrender_scenes.is_pyrender_scene(source):
        return pyrender_scenes.camera_from_pyrender(source)
    if is_trimesh(source):
        return viewer_camera(source)
    found = camera_of(source, size)
    if found is None:
        pair = (
            "; the size is the argument after it: size=(width, height)"
            if isinstance(source, tuple) and len(source) == 2
            else ""
        )
        raise SettingsError(
            f"cannot use a {type(source).__name__} as camera; expected a Camera, by Camera.perspective or Camera.pinhole, a camera"
            " file, a pyrender.Scene, node or camera, trimesh.Scene, pyvista.Plotter or Camera, Open3D intrinsics or camera, a matrix (3, 3), or a pair of one of these"
            f" and a pose (4, 4){pair}"
        )
    return found
