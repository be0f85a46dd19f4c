"""A scene as bytes that a browser draws: a line of JSON that says what lies where, and the arrays behind it."""

from __future__ import annotations

import gzip
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..scene.camera import Camera
from ..scene.lens import Orthographic, Perspective
from ..scene.model import Mesh, Scene
from ..scene.projection import Size
from ..scene.spheres import Spheres

ALIGNED = 4
"""Bytes to a multiple of which every array begins, counted from the end of the first line."""


class Packer:
    """Arrays one behind the other, and where they lie."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    def add(self, array: NDArray[Any]) -> dict[str, Any]:
        """Take an array; return its type as numpy writes it, its length and where it begins."""
        data = np.ascontiguousarray(array).tobytes()
        place = {"type": array.dtype.name, "length": array.size, "at": self._length}
        self._parts.append(data + bytes(-len(data) % ALIGNED))
        self._length += len(self._parts[-1])
        return place

    def bytes(self, head: dict[str, Any]) -> bytes:
        """Return the head as a line, and the arrays, packed by gzip."""
        line = json.dumps(head, separators=(",", ":")).encode() + b"\n"
        return gzip.compress(b"".join([line, *self._parts]), 6, mtime=0)


def packed_scene(scene: Scene, size: Size) -> bytes:
    """Return a scene and its cameras about the middle of the scene, packed by gzip; ``size``: of pictures by these cameras.

    Meshes with their colours (textures stay behind) and spheres. Raises SceneError for volumes.
    """
    if scene.volumes:
        raise SceneError(f"{scene.name or 'the scene'}: volumes cannot be shown in the browser; expected meshes or spheres")
    packer, middle = Packer(), scene.bounds.mean(0)
    cameras = list(scene.cameras) or [scene.default_camera(size)]
    head = {
        "name": scene.name,
        "contents": scene.contents,
        "half": [float(half) for half in (scene.bounds[1] - scene.bounds[0]) / 2],
        "up": [float(v) for v in scene.up],
        "background": scene.background,
        "radius": scene.default_radius(),
        "cameras": [packed_camera(camera, size, middle) for camera in cameras],
        "meshes": [_mesh(thing, middle, packer) for thing in scene.drawn if isinstance(thing, Mesh)],
        "spheres": [_spheres(thing, middle, packer) for thing in scene.drawn if isinstance(thing, Spheres)],
    }
    return packer.bytes(head)


def packed_camera(camera: Camera, size: Size, middle: NDArray[np.float64]) -> dict[str, Any]:
    """Return a camera about ``middle`` as values of JSON: pose (camera to world) and lens; matrices column by column."""
    pose = np.array(camera.pose, np.float64)
    pose[:3, 3] -= middle
    lens: dict[str, Any]
    match camera.lens:
        case Perspective(yfov=yfov):
            lens = {"yfov": yfov}
        case Orthographic(height=height):
            lens = {"height": height}
        case other:
            matrix = np.asarray(other.matrix(size))
            lens = {"matrix": matrix.T.ravel().tolist()}
    return {"name": camera.name or "camera", "pose": pose.T.ravel().tolist(), "radius": camera.ao_radius, **lens}


def _mesh(mesh: Mesh, middle: NDArray[np.float64], packer: Packer) -> dict[str, Any]:
    small = len(mesh.positions) <= 1 << 16
    packed: dict[str, Any] = {
        "positions": packer.add(mesh.positions.astype(np.float32)),
        "triangles": packer.add(mesh.triangles.astype(np.uint16 if small else np.uint32)),
        "places": packer.add(_places(mesh.transforms, middle)),
        "color": [float(v) for v in mesh.color],
    }
    if mesh.normals is not None:
        packed["normals"] = packer.add(_bytes_of(mesh.normals))
    if mesh.vertex_colors is not None:
        packed["colors"] = packer.add(mesh.vertex_colors)
    return packed


def _spheres(spheres: Spheres, middle: NDArray[np.float64], packer: Packer) -> dict[str, Any]:
    packed: dict[str, Any] = {
        "balls": packer.add(np.column_stack([spheres.centers, spheres.radii]).astype(np.float32)),
        "places": packer.add(_places(spheres.transforms, middle)),
        "color": [float(v) for v in spheres.color],
    }
    if spheres.colors is not None:
        packed["colors"] = packer.add(spheres.colors)
    return packed


def _places(transforms: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return transforms (k, 4, 4) to the scene about its middle, column by column."""
    about = transforms.copy()
    about[:, :3, 3] -= middle
    return about.transpose(0, 2, 1).astype(np.float32)


def _bytes_of(normals: NDArray[np.float32]) -> NDArray[np.int8]:
    """Return directions (n, 3) as (n, 4) signed bytes, for light only: occlusion has the triangles' own."""
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = np.nan_to_num(normals / np.abs(normals).max(1, keepdims=True))
    return np.pad(np.rint(127 * unit), ((0, 0), (0, 1))).astype(np.int8)
