"""Scenes of pyrender: read as they are, drawn by us. pyrender's own OpenGL is not needed.

Only what all distributions of pyrender share is used; ``Scene.bounds`` and ``Scene.scale`` are not (they fail under numpy 2).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera, Matrix, Size
from ..errors import SceneError
from ..scene import Draw, Scene
from .meshes import _encode

if TYPE_CHECKING:
    import pyrender

TRIANGLES = 4


class PyrenderLens:
    """The projection of a pyrender camera, whichever kind it is, at any image size."""

    def __init__(self, camera: Any) -> None:
        self._camera = camera

    def matrix(self, size: Size) -> Matrix:
        return np.asarray(self._camera.get_projection_matrix(*size), np.float64)


def is_pyrender_scene(thing: object) -> bool:
    """Whether ``thing`` is a ``pyrender.Scene``; does not import pyrender."""
    kind = type(thing)
    return kind.__name__ == "Scene" and kind.__module__.split(".")[0] == "pyrender"


def from_pyrender(scene: pyrender.Scene) -> Scene:
    """Meshes, poses, instances, colours and the main camera of a ``pyrender.Scene``. Raises SceneError when nothing can be drawn."""
    draws: list[Draw] = []
    for node in scene.mesh_nodes:
        if node.mesh.is_visible:
            pose = np.asarray(scene.get_pose(node), np.float64)
            draws += [d for p in node.mesh.primitives if (d := _draw(p, pose, node.name or node.mesh.name or "")) is not None]
    if not draws:
        raise SceneError("the pyrender scene has no triangles to draw")
    cameras = [] if scene.main_camera_node is None else [camera_from_pyrender(scene)]
    return Scene(draws, cameras=cameras, name=scene.name or "pyrender scene")


def camera_from_pyrender(scene: pyrender.Scene) -> Camera:
    """The main camera of a ``pyrender.Scene`` with its pose. Raises SceneError when there is none."""
    node = scene.main_camera_node
    if node is None:
        raise SceneError("the pyrender scene has no camera; add one with scene.add(camera, pose=...)")
    return Camera(PyrenderLens(node.camera), np.asarray(scene.get_pose(node), np.float64), node.camera.name or "pyrender")


def _draw(primitive: Any, pose: NDArray[np.float64], name: str) -> Draw | None:
    positions = np.asarray(primitive.positions, np.float32)
    if primitive.mode != TRIANGLES or not len(positions):
        return None
    indices = primitive.indices
    triangles = np.arange(len(positions)).reshape(-1, 3) if indices is None else np.asarray(indices).reshape(-1, 3)
    normals = None if primitive.normals is None else np.asarray(primitive.normals, np.float32)
    poses = primitive.poses
    transforms = pose[None] if poses is None else pose @ np.asarray(poses, np.float64).reshape(-1, 4, 4)
    material = primitive.material
    factor = getattr(material, "baseColorFactor", None)
    color = (0.8, 0.8, 0.8) if factor is None else _encode(np.asarray(factor, np.float64)[:3])
    vertex_colors = None
    if primitive.color_0 is not None:
        rgba = np.asarray(primitive.color_0, np.float64)
        rgba = rgba if rgba.shape[1] == 4 else np.column_stack([rgba, np.ones(len(rgba))])
        vertex_colors = np.round(np.clip(rgba, 0, 1) * 255).astype(np.uint8)
    return Draw(positions, triangles.astype(np.uint32), normals, color, vertex_colors, transforms, name)
