"""Cameras of other libraries, known by what they have: nothing of theirs is imported."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import SettingsError
from ..scene.camera import Camera
from ..scene.lens import Orthographic, Perspective
from ..scene.pose import look_at, pose_of
from ..scene.projection import Size
from .pyrender_scenes import PyrenderLens


def camera_of(source: Any, size: Size | None = None) -> Camera | None:
    """Return the camera of an object of another library; None for what is not known.

    - A pyrender camera, or a node that holds one. PyVista's ``Camera`` (``vtkCamera`` behind it), or a plotter. Open3D's
      ``PinholeCameraIntrinsic`` and ``PinholeCameraParameters``, and the camera of its renderers.
    - A calibration matrix (3, 3), for an image of ``size``.
    - A pair of any of these, and a camera-to-world pose (4, 4) in OpenGL axes, as pyrender's.

    Raises SettingsError.
    """
    if isinstance(source, tuple | list) and len(source) == 2 and np.shape(source[1]) in ((4, 4), (3, 4)):
        lens = source[0] if isinstance(source[0], Camera) else camera_of(source[0], size)
        return None if lens is None else Camera(lens.lens, pose_of(source[1]), lens.name, lens.ao_radius)
    if callable(getattr(source, "get_model_matrix", None)):
        return Camera.from_matrix(source.get_projection_matrix(), source.get_model_matrix()).named("open3d")
    if callable(getattr(source, "get_projection_matrix", None)):
        return Camera(PyrenderLens(source), name=str(getattr(source, "name", None) or "pyrender"))
    if callable(getattr(getattr(source, "camera", None), "get_projection_matrix", None)) and hasattr(source, "matrix"):
        return Camera(PyrenderLens(source.camera), pose_of(source.matrix), str(source.camera.name or source.name or "pyrender"))
    if all(hasattr(source, name) for name in ("position", "focal_point", "up", "view_angle", "clipping_range")):
        return _of_vtk(source)
    if hasattr(source, "renderer") and hasattr(source, "camera_position"):
        return camera_of(source.camera)
    if hasattr(source, "intrinsic_matrix") and hasattr(source, "width"):
        return _of_open3d(source, None)
    if hasattr(source, "extrinsic") and hasattr(getattr(source, "intrinsic", None), "intrinsic_matrix"):
        return _of_open3d(source.intrinsic, source.extrinsic)
    if np.shape(source) == (3, 3) and not isinstance(source, str):
        if size is None:
            raise SettingsError("camera: a calibration matrix needs an image's size; use Camera.from_intrinsics")
        return Camera.from_intrinsics(source, size)
    return None


def _of_vtk(source: Any) -> Camera:
    """Return PyVista's camera: angle in degrees from bottom to top, half the height of a parallel projection."""
    pose = look_at(source.position, source.focal_point, source.up)
    near, far = (float(v) for v in source.clipping_range)
    if getattr(source, "parallel_projection", False):
        return Camera(Orthographic(2 * float(source.parallel_scale), near, far), pose, "pyvista")
    angle = math.radians(float(source.view_angle))
    if getattr(source, "use_horizontal_view_angle", False):
        raise SettingsError("camera: VTK's horizontal view angle depends on the window; give Camera.perspective")
    return Camera(Perspective(angle, near, far), pose, "pyvista")


def _of_open3d(intrinsic: Any, extrinsic: Any) -> Camera:
    size = int(intrinsic.width), int(intrinsic.height)
    return Camera.from_intrinsics(intrinsic.intrinsic_matrix, size, world_to_camera=extrinsic).named("open3d")
