"""Meshes in GL buffers, and how they are drawn into a G-buffer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..graph.names import BAKED, COLOR, MATERIAL, NORMAL, SHADING_NORMAL
from ..scene.baked_visibility import BakedVisibility
from ..scene.bounds import named_positions
from ..scene.model import Mesh
from ..scene.srgb import encoded_rgb
from .programs import GpuResources, Program
from .scene_draw import SceneDraw
from .scene_textures import Sampled, SceneTextures

CHUNK = 1 << 18
"""Vertices converted and uploaded at a time, so that no second copy of a large mesh is made."""


@dataclass(frozen=True, slots=True, eq=False)
class _OnGpu:
    """A mesh, its vertex data by attribute (buffer, format), its triangles and its texture."""

    mesh: Mesh
    attributes: dict[str, tuple[Any, str]]
    index: Any
    texture: Sampled | None


@dataclass(frozen=True, slots=True, eq=False)
class _Call:
    """How a mesh is drawn: its program, vertex array, uniforms of its look, and its textures by uniform, as far as they are read."""

    program: Program
    array: moderngl.VertexArray
    look: Mapping[str, Any]
    textures: Mapping[str, Sampled]


class MeshBuffers:
    """Vertex data and textures of meshes, placed about ``center`` (3,), in GL objects."""

    def __init__(self, resources: GpuResources, meshes: Sequence[Mesh], center: NDArray[np.float64]) -> None:
        self._resources = resources
        self._center = center
        self._owned: list[Any] = []
        self._arrays: dict[Any, moderngl.VertexArray] = {}
        self._calls: dict[Any, _Call] = {}
        self._textures = SceneTextures(resources)
        try:
            self._meshes = [self._upload(mesh) for mesh in meshes]
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

    def draw(self, seen: SceneDraw) -> None:
        """Draw every mesh."""
        unit, kind = seen.first_unit, seen.program_key("mesh")
        for number, on_gpu in enumerate(self._meshes):
            if seen.leaves_out(on_gpu.mesh):
                continue
            call = self._calls.get((number, kind)) or self._prepared(number, kind, seen)
            call.program.set(seen.uniforms)
            call.program.set({**call.look, **seen.label(on_gpu.mesh)})
            for place, (uniform, texture) in enumerate(call.textures.items(), unit):
                texture.bind(place)
                call.program.set({uniform: place})
            call.array.render(moderngl.TRIANGLES, instances=len(on_gpu.mesh.transforms))

    def _prepared(self, number: int, kind: Any, seen: SceneDraw) -> _Call:
        """Return how a mesh is drawn by such a draw, with the program and the vertex array for it."""
        on_gpu = self._meshes[number]
        needed = _defines(on_gpu.mesh, seen)
        textures = {"u_texture": on_gpu.texture} if on_gpu.texture is not None and "TEXTURED" in needed else {}
        if on_gpu.mesh.baked is not None and BAKED in seen.writes:
            textures |= self._baked(on_gpu, on_gpu.mesh.baked)
        program = self._resources.program(*seen.draw.shaders["mesh"], {**needed, **seen.defines})
        array = self._arrays.get((number, program))
        if array is None:
            content = [(*on_gpu.attributes[n], n) for n in on_gpu.attributes if n in program.mgl]
            array = self._arrays[number, program] = self._resources.ctx.mgl.vertex_array(program.mgl, content, on_gpu.index)
        call = self._calls[number, kind] = _Call(program, array, _look(on_gpu.mesh, needed), textures)
        return call

    def _baked(self, on_gpu: _OnGpu, kept: BakedVisibility) -> dict[str, Sampled]:
        """Store what a mesh keeps, once somebody wants it, and return its texture."""
        if "a_baked" not in on_gpu.attributes:
            rows = np.ascontiguousarray(kept.rows, "f4")
            on_gpu.attributes["a_baked"] = self._buffer(rows), "1f" if kept.texture is None else "2f"
        return {} if kept.texture is None else {"u_baked": self._textures.sampled(kept.texture.picture)}

    def release(self) -> None:
        """Free every buffer and texture."""
        for array in self._arrays.values():
            array.release()
        for buffer in self._owned:
            buffer.release()
        self._textures.release()
        self._arrays, self._calls, self._owned, self._meshes = {}, {}, [], []


def _defines(mesh: Mesh, seen: SceneDraw) -> dict[str, int]:
    """Return what the shader of a mesh must do, and no more."""
    defines, shown = seen.target_defines, seen.shown
    smooth = {SHADING_NORMAL, COLOR} | (set() if "GEOMETRIC" in seen.defines else {NORMAL})
    if NORMAL in shown or smooth & shown:
        defines["NORMAL"] = 1
    if smooth & shown and mesh.normals is not None:
        defines["SMOOTH"] = 1
    colored, cut = COLOR in shown, mesh.cutoff is not None
    if cut:
        defines["CUT"] = 1
    if mesh.vertex_colors is not None and (colored or cut):
        defines["VERTEX_COLOR"] = 1
    if mesh.texture is not None and (colored or cut):
        defines["TEXTURED"] = 1
    if mesh.material is not None and MATERIAL in shown:
        defines["SHINY"] = 1
    if mesh.baked is not None and BAKED in shown:
        defines["BAKED_VERTEX" if mesh.baked.texture is None else "BAKED_TEXTURE"] = 1
        defines |= {} if mesh.baked.base_color is None else {"BAKED_IN_COLOR": 1}
    return defines


def _look(mesh: Mesh, defines: Mapping[str, int]) -> dict[str, Any]:
    """Return the uniforms of base colour: sRGB, and linear where a texture is multiplied."""
    material = mesh.material
    alpha = 1.0 if material is None else material.base_color[3]
    color = material.base_color[:3] if material is not None and "TEXTURED" in defines else mesh.color
    if mesh.baked is not None and mesh.baked.base_color is not None and "BAKED_IN_COLOR" in defines:
        color = mesh.baked.base_color if "TEXTURED" in defines else encoded_rgb(mesh.baked.base_color)
    look: dict[str, Any] = {"u_color": (*color, alpha)} | ({"u_cutoff": mesh.cutoff} if "CUT" in defines else {})
    if mesh.material is not None and "SHINY" in defines:
        look["u_material"] = (mesh.material.roughness, mesh.material.metallic)
    return look | ({"u_baked_strength": mesh.baked.strength} if mesh.baked is not None and "BAKED_TEXTURE" in defines else {})


def _snorm16(normals: NDArray[np.float32]) -> NDArray[np.int16]:
    """Return unit normals as 16-bit integers (n, 4), error below 2e-5; what is not finite becomes 0 and is replaced on the
    GPU."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.divide(normals, length, out=np.zeros_like(normals), where=np.isfinite(length) & (length > 0))
    out = np.zeros((len(normals), 4), np.int16)
    out[:, :3] = np.round(unit * 32767)
    return out
