"""The elements of a scene as instances, each of which is drawn as the box of what it may darken."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..graph.draws import DrawElements
from ..scene.ball_elements import ball_elements
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.prisms import placed_triangles
from ..scene.projection import Matrix, ViewConstants
from .loader import Functions
from .programs import GpuResources, Program

STRIP = 14
"""Corners of a box as one strip of triangles."""
GL_CULL_FACE, GL_CULL_FACE_MODE, GL_FRONT_FACE, GL_FRONT, GL_CW, GL_CCW = 0x0B44, 0x0B45, 0x0B46, 0x0404, 0x0900, 0x0901


@dataclass(frozen=True, slots=True)
class _Layout:
    """How elements lie in a buffer, 32-bit floats all of it. rows: those of a scene, with patches of a width."""

    rows: Callable[[Scene, float], Iterator[NDArray[np.float64]]]
    format: str
    attributes: tuple[str, ...]


def _triangle_rows(scene: Scene, patch: float) -> Iterator[NDArray[np.float64]]:
    """Yield three corners, about the middle of the scene, and the share of the triangle that alpha leaves."""
    for corners, solid, _ in placed_triangles(scene):
        yield np.column_stack([corners.reshape(-1, 9), solid])


LAYOUTS: Mapping[str, _Layout] = {
    "triangles": _Layout(_triangle_rows, "3f 3f 3f 1f/i", ("a_first", "a_second", "a_third", "a_solid")),
    "spheres": _Layout(ball_elements, "4f 3f/i", ("a_ball", "a_facing")),
}


class ElementBuffers:
    """The elements of ``scene`` of one kind in a GL buffer."""

    def __init__(self, resources: GpuResources, scene: Scene, elements: str, patch: float) -> None:
        self.patch = patch
        self._resources = resources
        self._middle = scene.bounds.mean(0)
        self._layout = LAYOUTS[elements]
        self._arrays: dict[Program, moderngl.VertexArray] = {}
        rows = [np.ascontiguousarray(some, "f4") for some in self._layout.rows(scene, patch)]
        self.count = sum(map(len, rows))
        self._buffer = resources.ctx.mgl.buffer(reserve=max(sum(some.nbytes for some in rows), 4))
        offset = 0
        for some in rows:
            if len(some):
                self._buffer.write(some, offset=offset)
            offset += some.nbytes

    def draw(self, draw: DrawElements, camera: Camera, view: ViewConstants, uniforms: Mapping[str, Any], onto: Matrix) -> None:
        """Draw the far side of every box into the bound framebuffer. ``onto``: as of :meth:`.SceneBuffers.draw`."""
        if not self.count:
            return
        from_middle = np.linalg.inv(camera.pose)
        from_middle[:3, 3] += from_middle[:3, :3] @ self._middle
        projection = onto @ view.projection
        defines = {**draw.defines, **({"PINHOLE": 1} if view.pinhole else {})}
        program = self._resources.program(*draw.shaders, defines)
        lens = {
            "u_view": tuple(from_middle.T.ravel()),
            "u_projection": tuple(projection.T.ravel()),
            "u_volume_radius": draw.radius,
            "u_per_radius": 1 / draw.radius,
        }
        program.set({name: value for name, value in {**uniforms, **lens}.items() if name in program.declared})
        array = self._arrays.get(program)
        if array is None:
            content = [(self._buffer, self._layout.format, *self._layout.attributes)]
            array = self._arrays[program] = self._resources.ctx.mgl.vertex_array(program.mgl, content)
        with _far_sides(self._resources.ctx.functions, mirrored=np.linalg.det(projection[:2, :2]) < 0):
            array.render(moderngl.TRIANGLE_STRIP, vertices=STRIP, instances=self.count)

    def release(self) -> None:
        """Free the buffer."""
        for array in self._arrays.values():
            array.release()
        self._buffer.release()
        self._arrays = {}


@contextmanager
def _far_sides(gl: Functions, *, mirrored: bool) -> Iterator[None]:
    """Within the block what faces away is drawn alone; what a caller has chosen comes back after it."""
    enable, disable = gl("glEnable", None, ctypes.c_uint), gl("glDisable", None, ctypes.c_uint)
    cull, front = gl("glCullFace", None, ctypes.c_uint), gl("glFrontFace", None, ctypes.c_uint)
    before = gl.integers(GL_CULL_FACE_MODE)[0], gl.integers(GL_FRONT_FACE)[0]
    cull(GL_FRONT)
    front(GL_CW if mirrored else GL_CCW)
    enable(GL_CULL_FACE)
    try:
        yield
    finally:
        disable(GL_CULL_FACE)
        cull(before[0])
        front(before[1])
