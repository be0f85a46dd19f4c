"""What every pass draws with: compiled programs, samplers, one triangle, small repeating textures. Once a context."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import ShaderError, near_miss
from ..glsl import preprocess
from ..graph.draws import FloatTable
from ..io.images import flipped
from .context import Context

FORMATS: Mapping[str, tuple[int, str]] = {
    "r8": (1, "f1"), "rgba8": (4, "f1"), "r16f": (1, "f2"), "rg16f": (2, "f2"), "rgba16f": (4, "f2"), "r32f": (1, "f4"), "rgba32f": (4, "f4"),
    "r32ui": (1, "u4"), "rgba32ui": (4, "u4"),
}  # fmt: skip
"""Texture formats of the graph: components and moderngl's dtype. All can be drawn into on OpenGL ES 3 and WebGL2."""

_UNIFORM = re.compile(r"\buniform\s+(?:\w+\s+)?\w+\s+(\w+)\s*(?:\[|;)")


@contextmanager
def _no_stray_program(ctx: Context) -> Iterator[None]:
    """moderngl forgets the program that it has made when a shader does not compile. Its name is the next, or the one after."""
    exists = ctx.functions("glIsProgram", ctypes.c_ubyte, ctypes.c_uint)
    delete = ctx.functions("glDeleteProgram", None, ctypes.c_uint)
    next_ = ctx.functions("glCreateProgram", ctypes.c_uint)()
    delete(next_)
    free = [name for name in (next_, next_ + 1) if not exists(name)]
    try:
        yield
    except moderngl.Error:
        for name in filter(exists, free):
            delete(name)
        raise


class Program:
    """A linked program whose uniforms are set only when they change."""

    def __init__(self, ctx: Context, vertex: preprocess.ShaderSource, fragment: preprocess.ShaderSource, name: str) -> None:
        try:
            with _no_stray_program(ctx):
                self.mgl = ctx.mgl.program(vertex_shader=vertex.text, fragment_shader=fragment.text)
        except moderngl.Error as error:
            part = vertex if "vertex_shader" in str(error) else fragment
            log = "; ".join(line.strip() for line in part.locate(str(error)).splitlines() if ":" in line)
            raise ShaderError(f"{name} ({ctx.dialect}, {ctx.renderer}): {log}") from None
        self.name = name
        self.declared = frozenset(_UNIFORM.findall(vertex.text)) | frozenset(_UNIFORM.findall(fragment.text))
        self._uniforms: dict[str, Any] = {key: self.mgl[key] for key in self.mgl if isinstance(self.mgl[key], moderngl.Uniform)}
        self._last: dict[str, Any] = {}
        self.user: object = None
        """Whoever set its uniforms last, and need not set them again."""

    def set(self, values: Mapping[str, Any]) -> None:
        """Set uniforms. Names that the driver optimised away are passed over; names no source declares raise ShaderError."""
        for name, value in values.items():
            last = self._last.get(name)
            if last is value or (last is not None and last == value):
                continue
            self._last[name] = value
            uniform = self._uniforms.get(name)
            if uniform is None:
                if name not in self.declared:
                    raise ShaderError(f"{self.name} declares no uniform '{name}'.{near_miss(name, self.declared)}")
            elif isinstance(value, FloatTable):
                uniform.write(value.data)
            else:
                uniform.value = value

    def release(self) -> None:
        self.mgl.release()


class GpuResources:
    """GL objects that outlive a frame; ``release`` frees them all."""

    def __init__(self, ctx: Context) -> None:
        self.ctx = ctx
        mgl = ctx.mgl
        # moderngl goes back to the framebuffer it believes bound whenever it makes something; this one is always there.
        self._pixel = mgl.texture((1, 1), 4)
        self.home = mgl.framebuffer([self._pixel])
        self._corner = mgl.buffer(np.array([-1, -1, 3, -1, -1, 3], "f4").tobytes())
        self._programs: dict[Any, Program] = {}
        self._triangles: dict[Program, moderngl.VertexArray] = {}
        self._tables: dict[FloatTable, moderngl.Texture] = {}
        # Samplers of our own: a caller's sampler left on a unit, or a caller's texture with comparison or filtering
        # on, would otherwise change what we read.
        self._clamp = self._sampler(repeat=False)
        self._repeat = self._sampler(repeat=True)

    def _sampler(self, *, repeat: bool) -> moderngl.Sampler:
        sampler = self.ctx.mgl.sampler(repeat_x=repeat, repeat_y=repeat, compare_func="")
        sampler.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return sampler

    def program(self, vertex: str, fragment: str, defines: Mapping[str, preprocess.Define]) -> Program:
        """Return the program of two shaders under ``defines``, compiled once. Raises ShaderError."""
        key = (vertex, fragment, tuple(sorted(defines.items())))
        program = self._programs.get(key)
        if program is None:
            dialect = self.ctx.dialect
            texts = [preprocess.build(name, defines, dialect) for name in (vertex, fragment)]
            program = self._programs[key] = Program(self.ctx, texts[0], texts[1], fragment)
        return program

    def triangle(self, fragment: str, defines: Mapping[str, preprocess.Define]) -> tuple[Program, moderngl.VertexArray]:
        """Return a full-screen program and its vertex array."""
        program = self.program("fullscreen.vert", fragment, defines)
        return program, self.corners(program)

    def corners(self, program: Program) -> moderngl.VertexArray:
        """Return the vertex array of a program that draws one triangle over its target."""
        vao = self._triangles.get(program)
        if vao is None:
            vao = self._triangles[program] = self.ctx.mgl.vertex_array(program.mgl, [(self._corner, "2f", "a_corner")])
        return vao

    def table(self, values: FloatTable) -> moderngl.Texture:
        """Return a small float texture of ``values`` (h, w, channels), made once, to be read with ``repeat``."""
        texture = self._tables.get(values)
        if texture is None:
            h, w, channels = values.shape
            texture = self._tables[values] = self.ctx.mgl.texture((w, h), channels, values.data, dtype="f4")
        return texture

    def upload(self, array: NDArray[Any]) -> moderngl.Texture:
        """Return an array (h, w) or (h, w, channels), row 0 on top, as a texture of the caller's to release: uint8 as 8
        bits, else floats."""
        h, w = array.shape[:2]
        dtype = "f1" if array.dtype == np.uint8 else "f4"
        data = flipped(array if dtype == "f1" else array.astype(np.float32))
        texture = self.ctx.mgl.texture(
            (w, h), 1 if array.ndim == 2 else array.shape[2], data.tobytes(), alignment=1, dtype=dtype
        )
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return texture

    def bind(self, unit: int, texture: moderngl.Texture | moderngl.Texture3D, *, repeat: bool = False) -> None:
        """Bind a texture, and our own sampler with it, to a unit."""
        texture.use(unit)
        (self._repeat if repeat else self._clamp).use(unit)

    def unbind(self, units: int) -> None:
        """Take our samplers off the first ``units`` units."""
        for unit in range(units):
            self._clamp.clear(unit)

    def release(self) -> None:
        """Free every GL object of these."""
        self.ctx.functions("glUseProgram", None, ctypes.c_uint)(0)  # a program in use would outlive its deletion
        for vao in self._triangles.values():
            vao.release()
        for program in self._programs.values():
            program.release()
        for texture in self._tables.values():
            texture.release()
        for thing in (self._corner, self._clamp, self._repeat, self.home, self._pixel):
            thing.release()
        self._programs, self._triangles, self._tables = {}, {}, {}
