"""A scene's vertex data in GL buffers, and how it is drawn into a G-buffer."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..glsl.preprocess import Define
from ..graph.draws import DrawScene
from ..graph.names import COLOR, DEPTH, DEPTH_LAYER_2, NORMAL, SHADING_NORMAL
from ..scene.bounds import named_positions
from ..scene.camera import Camera
from ..scene.model import Mesh, Scene
from ..scene.projection import Matrix, ViewConstants
from .programs import GpuResources, Program
from .scene_textures import Sampled, SceneTextures

CHUNK = 1 << 18
"""Vertices converted and uploaded at a time, so that no second copy of a large mesh is made."""

STIFF = 1 << 12
"""Ratio of far to near from which depth is drawn in logarithms, at the price of an early depth test: beyond it a step of
24-bit depth is more than 1/4000 of the far distance."""

LIGHT = (-0.36, 0.48, 0.8)
"""Unit vector to the light in view space: over the viewer's left shoulder."""


@dataclass(frozen=True, slots=True, eq=False)
class _OnGpu:
    """A mesh, its vertex data by attribute (buffer, format), its triangles and its texture."""

    mesh: Mesh
    attributes: dict[str, tuple[Any, str]]
    index: Any
    texture: Sampled | None


_Kind = tuple[tuple[str, str], tuple[str, ...], tuple[tuple[str, Define], ...]]
"""Shader, targets and defines of a draw."""


@dataclass(frozen=True, slots=True, eq=False)
class _Call:
    """How a mesh is drawn: its program, vertex array, uniforms of colour, and texture where that is read."""

    program: Program
    array: moderngl.VertexArray
    look: Mapping[str, Any]
    texture: Sampled | None


class SceneBuffers:
    """A scene's vertex data and textures in GL objects."""

    def __init__(self, resources: GpuResources, scene: Scene) -> None:
        self.scene = scene
        self._resources = resources
        self._owned: list[Any] = []
        self._arrays: dict[Any, moderngl.VertexArray] = {}
        self._calls: dict[tuple[int, _Kind], _Call] = {}
        self._textures = SceneTextures(resources)
        self._center = scene.bounds.mean(0)
        try:
            self._meshes = [self._upload(mesh) for mesh in scene.drawn]
        except BaseException:
            self.release()
            raise

    def _upload(self, mesh: Mesh) -> _OnGpu:
        count = len(mesh.positions)
        # Vertices about the middle of the mesh, transforms about the middle of the scene: differences of large
        # coordinates are taken here, in 64-bit.
        named = named_positions(mesh)
        middle = (named.min(0).astype(np.float64) + named.max(0)) / 2
        place = mesh.transforms.copy()
        place[:, :3, 3] += place[:, :3, :3] @ middle - self._center
        buffers: dict[str, tuple[Any, str]] = {
            "a_position": (self._fill(count, 12, lambda s: (mesh.positions[s] - middle).astype("f4")), "3f"),
            "a_model": (self._buffer(np.ascontiguousarray(place.transpose(0, 2, 1), "f4")), "16f/i"),
        }
        if mesh.normals is not None:
            normals = mesh.normals
            buffers["a_normal"] = (self._fill(count, 8, lambda s: _snorm16(normals[s])), "4i2")
        if mesh.vertex_colors is not None:
            buffers["a_color"] = (self._buffer(np.ascontiguousarray(mesh.vertex_colors)), "4f1")
        texture = None
        if mesh.texture is not None and mesh.uv is not None:
            texture = self._textures.sampled(mesh.texture)
            buffers["a_uv"] = (self._buffer(np.ascontiguousarray(mesh.uv, "f4")), "2f")
        return _OnGpu(mesh, buffers, self._buffer(np.ascontiguousarray(mesh.triangles)), texture)

    def _buffer(self, data: NDArray[Any] | None = None, *, reserve: int = 0) -> moderngl.Buffer:
        made = self._resources.ctx.mgl.buffer(data, reserve=reserve)
        self._owned.append(made)
        return made

    def _fill(self, count: int, stride: int, part: Any) -> moderngl.Buffer:
        buffer = self._buffer(reserve=max(count * stride, 1))
        for start in range(0, count, CHUNK):
            buffer.write(np.ascontiguousarray(part(slice(start, start + CHUNK))), offset=start * stride)
        return buffer

    def draw(
        self,
        draw: DrawScene,
        camera: Camera,
        view: ViewConstants,
        writes: Sequence[str],
        uniforms: Mapping[str, Any],
        cover: tuple[float, float] = (1.0, 1.0),
    ) -> None:
        """Draw everything before ``camera`` into the bound framebuffer, whose targets are ``writes`` in this order.

        ``cover``: width and height of the targets in those of the image, whose lower left corner they share.
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
        projection = projection * _near_one(view.w1 * farthest + view.w0)
        projection = _onto(projection, cover)
        shared = {
            "u_view": tuple(from_center.T.ravel()),
            "u_projection": tuple(projection.T.ravel()),
            "u_light": LIGHT,
            **uniforms,
        }
        unit, kind = len(draw.samplers), (draw.shader, tuple(writes), tuple(sorted(defines.items())))
        for number, on_gpu in enumerate(self._meshes):
            call = self._calls.get((number, kind)) or self._prepared(number, kind, defines)
            call.program.set(shared)
            call.program.set(call.look)
            if call.texture is not None:
                call.texture.bind(unit)
                call.program.set({"u_texture": unit})
            call.array.render(moderngl.TRIANGLES, instances=len(on_gpu.mesh.transforms))

    def _prepared(self, number: int, kind: _Kind, defines: Mapping[str, Define]) -> _Call:
        """Return how a mesh is drawn by such a draw, with the program and the vertex array for it."""
        on_gpu, (shader, writes, _) = self._meshes[number], kind
        needed = _defines(on_gpu.mesh, writes, defines)
        program = self._resources.program(*shader, {**needed, **defines})
        array = self._arrays.get((number, program))
        if array is None:
            content = [(*on_gpu.attributes[n], n) for n in on_gpu.attributes if n in program.mgl]
            array = self._arrays[number, program] = self._resources.ctx.mgl.vertex_array(program.mgl, content, on_gpu.index)
        texture = on_gpu.texture if "TEXTURED" in needed else None
        call = self._calls[number, kind] = _Call(program, array, _look(on_gpu.mesh, needed), texture)
        return call

    def _depth_range(self, from_center: Matrix) -> tuple[float, float]:
        """Smallest and largest linear depth of the scene's bounding box."""
        half = (self.scene.bounds[1] - self.scene.bounds[0]) / 2
        middle = -from_center[2, 3]
        reach = float(np.abs(from_center[2, :3]) @ half)
        return middle - reach, middle + reach

    def release(self) -> None:
        """Free every buffer."""
        for array in self._arrays.values():
            array.release()
        for buffer in self._owned:
            buffer.release()
        self._textures.release()
        self._arrays, self._calls, self._owned, self._meshes = {}, {}, [], []


def _onto(projection: Matrix, cover: tuple[float, float]) -> Matrix:
    """Return a projection onto targets that are so much larger than the image."""
    onto = np.diag([1 / cover[0], 1 / cover[1], 1.0, 1.0])
    onto[:2, 3] = onto[0, 0] - 1, onto[1, 1] - 1
    return onto @ projection


def fit_depth_range(view: ViewConstants, nearest: float, farthest: float) -> Matrix:
    """Return the projection of ``view`` with its depth row rebuilt so that the depth buffer spans just what can be seen.

    The clip planes stay where the camera put them unless the scene lies between them. Reversed, infinite and 0..1
    projections become OpenGL's -1..1, so one depth test serves all; x, y and w are untouched.
    """
    near, far = view.near, view.far
    margin = 1e-3 * (farthest - nearest) + 1e-6 * max(abs(nearest), abs(farthest))
    near = max(near, nearest - margin)
    far = min(far, max(farthest + margin, near * (1 + 1e-3) + margin))
    if not far > near:  # the whole scene lies outside: any valid range will do, everything is clipped
        near, far = view.near, view.near + max(abs(view.near), 1.0)
    m = view.projection.copy()
    w = {z: view.w1 * z + view.w0 for z in (near, far)}
    slope = (w[far] + w[near]) / (far - near)
    m[2] = (0, 0, -slope, -w[near] - slope * near)
    return m


def _near_one(w: float) -> float:
    """Return the power of two that brings clip coordinates with this w near 1: some drivers square them."""
    return math.ldexp(1.0, -min(max(math.frexp(w)[1], -1000), 1000)) if w and math.isfinite(w) else 1.0


def log_depth(view: ViewConstants, projection: Matrix) -> tuple[Matrix, tuple[float, float]] | None:
    """For ranges in which plain depth would not tell far surfaces apart: what draws depth in logarithms; None for others.

    That is the projection with its far plane at infinity (32-bit floats would miss a plane so near to 1; depth above 1 fails
    the test instead), and (1 / near, 1 / log2(far / near)). A step of plain depth is the share ``far / near 2^-24`` of the
    far distance, a step of its logarithm ``ln(far / near) 2^-24`` of any.
    """
    if view.w0 != 0 or view.w1 == 0:
        return None
    ends = [end * view.w1 - float(projection[2, 2]) for end in (1, -1)]
    if 0 in ends:  # no range at all: everything is clipped
        return None
    near, far = (-float(projection[2, 3]) / end for end in ends)
    if not far > STIFF * near > 0:
        return None
    endless = projection.copy()
    endless[2] = (0, 0, -view.w1, -2 * view.w1 * near)
    return endless, (1 / near, 1 / math.log2(far / near))


TARGETS = {
    DEPTH: "DEPTH_TARGET",
    DEPTH_LAYER_2: "DEPTH_TARGET",
    NORMAL: "NORMAL_TARGET",
    SHADING_NORMAL: "SHADING_NORMAL_TARGET",
    COLOR: "COLOR",
}
"""Resource -> the define that makes the shader write it."""


def _defines(mesh: Mesh, writes: Sequence[str], given: Mapping[str, Define]) -> dict[str, int]:
    """Return what the shader of a mesh must do, and no more."""
    defines: dict[str, int] = {"TARGETS": len(writes)} | {TARGETS[name]: index for index, name in enumerate(writes)}
    smooth = {SHADING_NORMAL, COLOR} | (set() if "GEOMETRIC" in given else {NORMAL})
    if NORMAL in writes or smooth & set(writes):
        defines["NORMAL"] = 1
    if smooth & set(writes) and mesh.normals is not None:
        defines["SMOOTH"] = 1
    colored, cut = COLOR in writes, mesh.cutoff is not None
    if cut:
        defines["CUT"] = 1
    if mesh.vertex_colors is not None and (colored or cut):
        defines["VERTEX_COLOR"] = 1
    if mesh.texture is not None and (colored or cut):
        defines["TEXTURED"] = 1
    return defines


def _look(mesh: Mesh, defines: Mapping[str, int]) -> dict[str, Any]:
    """Return the uniforms of base colour: sRGB, and linear where a texture is multiplied."""
    material = mesh.material
    alpha = 1.0 if material is None else material.base_color[3]
    color = material.base_color[:3] if material is not None and "TEXTURED" in defines else mesh.color
    return {"u_color": (*color, alpha)} | ({"u_cutoff": mesh.cutoff} if "CUT" in defines else {})


def _snorm16(normals: NDArray[np.float32]) -> NDArray[np.int16]:
    """Return unit normals as 16-bit integers (n, 4), error below 2e-5; what is not finite becomes 0 and is replaced on the
    GPU."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.divide(normals, length, out=np.zeros_like(normals), where=np.isfinite(length) & (length > 0))
    out = np.zeros((len(normals), 4), np.int16)
    out[:, :3] = np.round(unit * 32767)
    return out
