"""Scenes of pyrender: read as they are, drawn by us. pyrender's own OpenGL is not needed.

Only what all distributions of pyrender share is used; ``Scene.bounds`` and ``Scene.scale`` are not (they fail under numpy 2).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.camera import Camera, Pinhole
from ..scene.model import Mesh, Scene
from ..scene.projection import Matrix, Size
from .trimesh_scenes import _encode

if TYPE_CHECKING:
    import pyrender

TRIANGLES = 4


class PyrenderLens:
    """The projection of a pyrender camera, whichever kind it is, at any image size."""

    def __init__(self, camera: Any) -> None:
        self._camera = camera

    def matrix(self, size: Size) -> Matrix:
        c = self._camera
        if hasattr(c, "fx"):  # its own matrix doubles the intrinsics on macOS, for the window that it opens there
            return Pinhole(c.fx, c.fy, c.cx, c.cy, *size, c.znear, c.zfar).matrix(size)
        return np.asarray(c.get_projection_matrix(*size), np.float64)


def is_pyrender_scene(thing: object) -> bool:
    """Whether ``thing`` is a ``pyrender.Scene``; does not import pyrender."""
    kinds = type(thing).__mro__
    return any(kind.__name__ == "Scene" and kind.__module__.split(".")[0] == "pyrender" for kind in kinds)


def from_pyrender(scene: pyrender.Scene) -> Scene:
    """Meshes, poses, instances, colours and the main camera of a ``pyrender.Scene``. Raises SceneError when nothing can be drawn."""
    draws: list[Mesh] = []
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


def _draw(primitive: Any, pose: NDArray[np.float64], name: str) -> Mesh | None:
    positions = np.asarray(primitive.positions, np.float32)
    if primitive.mode != TRIANGLES or len(positions) < 3:
        return None
    indices = np.arange(len(positions)) if primitive.indices is None else np.asarray(primitive.indices).ravel()
    triangles = indices[: len(indices) // 3 * 3].reshape(-1, 3)
    normals = None if primitive.normals is None else np.asarray(primitive.normals, np.float32)
    poses = primitive.poses
    transforms = pose[None] if poses is None else pose @ np.asarray(poses, np.float64).reshape(-1, 4, 4)
    factor = getattr(primitive.material, "baseColorFactor", None)
    color = (0.8, 0.8, 0.8) if factor is None else _encode(np.asarray(factor, np.float64)[:3])
    return Mesh(positions, triangles.astype(np.uint32), normals, color, _vertex_colors(primitive), transforms, name)


def _vertex_colors(primitive: Any) -> NDArray[np.uint8] | None:
    """(n, 4) uint8: the colours of the vertices times the texture there; None without either."""
    parts = [
        part for part in (_rgba(primitive.color_0), _sampled(primitive.material, primitive.texcoord_0)) if part is not None
    ]
    return np.round(np.prod(parts, axis=0) * 255).astype(np.uint8) if parts else None


def _sampled(material: Any, uv: NDArray[Any] | None) -> NDArray[np.float64] | None:
    """The base colour texture at the vertices, (n, 4) in 0..1. Row 0 of its image is on top, v points up."""
    image = getattr(getattr(material, "baseColorTexture", None), "source", None)
    if image is None or uv is None:
        return None
    pixels = np.asarray(image)
    pixels = pixels[..., None] if pixels.ndim == 2 else pixels
    h, w = pixels.shape[:2]
    column, row = (np.mod((uv[:, 0], 1 - uv[:, 1]), 1) * [[w], [h]]).astype(int)
    found = pixels[row, column].astype(np.float64)
    return _rgba(found / 255 if pixels.dtype == np.uint8 else found)


def _rgba(color: NDArray[Any] | None) -> NDArray[np.float64] | None:
    """Grey, grey and alpha, RGB or RGBA (n, 1..4) in 0..1 as RGBA."""
    if color is None:
        return None
    given = np.clip(np.asarray(color, np.float64), 0, 1)
    rgb, alpha = (given[:, :3], given[:, 3:]) if given.shape[1] > 2 else (given[:, [0, 0, 0]], given[:, 1:])
    return np.column_stack([rgb, alpha if alpha.shape[1] else np.ones(len(given))])
