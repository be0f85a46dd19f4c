"""A scene in GL objects, and how it is drawn into a G-buffer: each kind of thing by its own buffers and shaders."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import DrawElements, DrawScene
from ..graph.names import LABELS
from ..scene.camera import Camera
from ..scene.labels import scene_labels
from ..scene.model import Mesh, Scene
from ..scene.projection import Matrix, ViewConstants
from ..scene.spheres import Spheres
from ..scene.volume import Volume
from .depth_range import fit_depth_range, log_depth, near_one
from .element_buffers import ElementBuffers
from .mesh_buffers import MeshBuffers
from .programs import GpuResources
from .scene_draw import SceneDraw, ThingBuffers
from .sphere_buffers import SphereBuffers
from .volume_buffers import VolumeBuffers

LIGHT = (-0.36, 0.48, 0.8)
"""Unit vector to the light in view space: over the viewer's left shoulder."""

KINDS: Mapping[type, Callable[[GpuResources, Sequence[Any], NDArray[np.float64]], ThingBuffers]] = {
    Mesh: MeshBuffers,
    Spheres: SphereBuffers,
    Volume: VolumeBuffers,
}
"""Things of a scene, in the order in which they are drawn -> what holds them on the GPU."""


class SceneBuffers:
    """A scene in GL objects."""

    def __init__(self, resources: GpuResources, scene: Scene) -> None:
        self.scene = scene
        self._resources = resources
        self._elements: dict[str, ElementBuffers] = {}
        self._parts: list[ThingBuffers] = []
        self._center = scene.bounds.mean(0)
        try:
            for kind, buffers in KINDS.items():
                if things := [thing for thing in scene.drawn if isinstance(thing, kind)]:
                    self._parts.append(buffers(resources, things, self._center))
        except BaseException:
            self.release()
            raise

    def draw(
        self,
        draw: DrawScene,
        camera: Camera,
        view: ViewConstants,
        writes: Sequence[str],
        uniforms: Mapping[str, Any],
        onto: Matrix,
        drawn_depth: Callable[[], NDArray[np.float32]] | None,
    ) -> None:
        """Draw everything before ``camera`` into the bound framebuffer, whose targets are ``writes`` in this order.

        onto: (4, 4) from clip coordinates of the image to those of the targets. drawn_depth: reads their linear depth.
        """
        defines = draw.defines
        to_view = np.asarray(np.linalg.inv(camera.pose), np.float64)
        from_center = to_view.copy()
        from_center[:3, 3] += to_view[:3, :3] @ self._center
        nearest, farthest = self._depth_range(from_center)
        projection = fit_depth_range(view, nearest, farthest)
        if stiff := log_depth(view, projection):
            projection, u_log = stiff
            uniforms, defines = {**uniforms, "u_log": u_log}, {**defines, "LOG_DEPTH": 1}
        projection = onto @ projection * near_one(view.w1 * farthest + view.w0)
        shared = {
            "u_view": tuple(from_center.T.ravel()),
            "u_projection": tuple(projection.T.ravel()),
            "u_light": LIGHT,
            **uniforms,
        }
        labels = scene_labels(self.scene).of if LABELS in writes else {}
        seen = SceneDraw(draw, tuple(writes), defines, shared, view, from_center, projection, drawn_depth, labels)
        for part in self._parts:
            part.draw(seen)

    def draw_elements(
        self, draw: DrawElements, camera: Camera, view: ViewConstants, uniforms: Mapping[str, Any], onto: Matrix
    ) -> None:
        """Draw the space around every element into the bound framebuffer. ``onto``: as of :meth:`draw`."""
        made = self._elements.get(draw.elements)
        if made is None or made.patch != draw.patch:
            if made is not None:
                made.release()
            made = self._elements[draw.elements] = ElementBuffers(self._resources, self.scene, draw.elements, draw.patch)
        made.draw(draw, camera, view, uniforms, onto)

    def _depth_range(self, from_center: Matrix) -> tuple[float, float]:
        """Smallest and largest linear depth of the scene's bounding box."""
        half = (self.scene.bounds[1] - self.scene.bounds[0]) / 2
        middle = -from_center[2, 3]
        reach = float(np.abs(from_center[2, :3]) @ half)
        return middle - reach, middle + reach

    def release(self) -> None:
        """Free every GL object of the scene."""
        for part in self._parts:
            part.release()
        self._parts = []
        for made in self._elements.values():
            made.release()
        self._elements = {}
