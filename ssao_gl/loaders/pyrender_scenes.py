"""Scenes of pyrender: read as they are, drawn by us. pyrender's own OpenGL is not needed.

Only what all distributions of pyrender share is used; ``Scene.bounds`` and ``Scene.scale`` are not (they fail under numpy 2).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, one_line
from ..scene.camera import Camera
from ..scene.lamps import Lamp, LampKind
from ..scene.lens import Pinhole
from ..scene.material import Material
from ..scene.model import DEFAULT_COLOR, Mesh, Scene
from ..scene.projection import Matrix, Size
from .finished import finished
from .mesh_building import linear_colors
from .notes import Notes
from .pyrender_materials import PyrenderLooks
from .strips import fan_triangles, strip_triangles

if TYPE_CHECKING:
    import pyrender

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6


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


def from_pyrender(scene: pyrender.Scene, *, point_size: float | None = None, painted: Mapping[Any, Any] | None = None) -> Scene:
    """Return meshes, poses, instances, materials, background, lights and the main camera of a ``pyrender.Scene``.

    point_size: of points, scene units; None for one that closes their surface. painted: node -> grey or (r, g, b), 0 to 255; its
    nodes alone, in these colours. Raises SceneError when nothing can be drawn.
    """
    notes = Notes()
    looks = PyrenderLooks(notes)
    draws: list[Mesh] = []
    for node in scene.mesh_nodes:
        if node.mesh.is_visible and (painted is None or node in painted):
            pose = np.asarray(scene.get_pose(node), np.float64)
            placed = [
                mesh
                for primitive in node.mesh.primitives
                for mesh in _draw(primitive, pose, node.name or node.mesh.name or "", looks, point_size)
            ]
            draws += placed if painted is None else [_painted(mesh, painted[node]) for mesh in placed]
    if not draws:
        raise SceneError("the pyrender scene has no triangles to draw")
    cameras = [] if scene.main_camera_node is None else [camera_from_pyrender(scene)]
    name = scene.name or "pyrender scene"
    made = finished(Scene(draws, cameras, (0.0, 1.0, 0.0), name, lamps=_lamps(scene, notes)), notes)
    notes.say(name)
    return dataclasses.replace(made, background=_background(scene))


def _lamps(scene: Any, notes: Notes) -> list[Lamp]:
    """The lights of the scene; what is broken is noted and left out."""
    found: list[Lamp] = []
    for kind in get_args(LampKind):
        for node in getattr(scene, f"{kind}_light_nodes", ()):
            light = node.light
            try:
                r, g, b = np.asarray(light.color, np.float64)[:3] * float(light.intensity)
                cone = getattr(light, "innerConeAngle", 0.0), getattr(light, "outerConeAngle", 0.0)
                reach = getattr(light, "range", None)
                found.append(Lamp.hung(kind, np.asarray(scene.get_pose(node), np.float64), (r, g, b), reach, cone))
            except Exception as error:  # the picture can be drawn without
                notes.add(f"a light of pyrender is left out ({one_line(error, 100)})")
    return found


def _painted(mesh: Mesh, color: Any) -> Mesh:
    """Return the mesh in one colour: grey or (r, g, b), 0 to 255."""
    given = np.clip(np.asarray(color, np.float64).ravel(), 0, 255)
    if given.shape not in ((1,), (3,)):
        raise SceneError(f"the colour {color!r} of node '{mesh.name}': expected one number or three, 0 to 255")
    colors = np.full((len(mesh.positions), 4), 255, np.uint8)
    colors[:, :3] = np.round(given)
    return dataclasses.replace(mesh, vertex_colors=colors, material=Material(), uv=None)


def _background(scene: Any) -> tuple[float, float, float, float] | None:
    given = np.ones(4) if scene.bg_color is None else np.clip(np.asarray(scene.bg_color, np.float64), 0, 1)
    if given.shape not in ((3,), (4,)):
        return None
    r, g, b, a = (float(value) for value in (*given, 1.0)[:4])
    return r, g, b, a


def camera_from_pyrender(scene: pyrender.Scene) -> Camera:
    """The main camera of a ``pyrender.Scene`` with its pose. Raises SceneError when there is none."""
    node = scene.main_camera_node
    if node is None:
        raise SceneError("the pyrender scene has no camera; add one with scene.add(camera, pose=...)")
    return Camera(PyrenderLens(node.camera), np.asarray(scene.get_pose(node), np.float64), node.camera.name or "pyrender")


def _draw(primitive: Any, pose: NDArray[np.float64], name: str, looks: PyrenderLooks, point_size: float | None) -> list[Mesh]:
    """The meshes of a primitive: one, or one at each pose for points; none where nothing can be drawn."""
    positions = np.asarray(primitive.positions, np.float32)
    normals = None if primitive.normals is None else np.asarray(primitive.normals, np.float32)
    poses = primitive.poses
    transforms = pose[None] if poses is None else pose @ np.asarray(poses, np.float64).reshape(-1, 4, 4)
    if primitive.mode == POINTS and len(positions):
        colors = None if primitive.color_0 is None else linear_colors(_rgba(primitive.color_0))
        return [_points(positions, matrix, colors, normals, name, point_size) for matrix in transforms]
    indices = np.arange(len(positions)) if primitive.indices is None else np.asarray(primitive.indices).ravel().astype(np.int64)
    if primitive.mode == TRIANGLES:
        triangles = indices[: len(indices) // 3 * 3].reshape(-1, 3)
    elif primitive.mode in (STRIP, FAN):
        triangles = (strip_triangles if primitive.mode == STRIP else fan_triangles)(indices)
    else:
        return []
    if not len(triangles):
        return []
    uv, material = looks.material(primitive, len(positions))
    colors = None
    if primitive.color_0 is not None:
        colors = linear_colors(_rgba(primitive.color_0), np.array(material.base_color))
        material = dataclasses.replace(material, base_color=(1.0, 1.0, 1.0, 1.0))
    return [Mesh(positions, triangles.astype(np.uint32), normals, DEFAULT_COLOR, colors, transforms, name, uv, material)]


def _points(
    positions: NDArray[np.float32], matrix: NDArray[np.float64], colors: NDArray[np.uint8] | None,
    normals: NDArray[np.float32] | None, name: str, point_size: float | None,
) -> Mesh:  # fmt: skip
    world = positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    turned = None if normals is None else normals @ np.linalg.pinv(matrix[:3, :3])
    return Mesh.from_points(world, colors, None if point_size is None else point_size / 2, normals=turned, name=name)


def _rgba(color: NDArray[Any]) -> NDArray[np.float64]:
    """Grey, grey and alpha, RGB or RGBA (n, 1..4) in 0..1 as RGBA."""
    given = np.clip(np.asarray(color, np.float64), 0, 1)
    rgb, alpha = (given[:, :3], given[:, 3:]) if given.shape[1] > 2 else (given[:, [0, 0, 0]], given[:, 1:])
    return np.column_stack([rgb, alpha if alpha.shape[1] else np.ones(len(given))])
