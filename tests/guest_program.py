"""A program that left OpenGL in the oddest state it could, and everything that OpenGL can tell about its state."""

from __future__ import annotations

import ctypes
from typing import Any

from ssao_gl.gl.context import Context

I, U, F, D, P, B = ctypes.c_int, ctypes.c_uint, ctypes.c_float, ctypes.c_double, ctypes.c_void_p, ctypes.c_ubyte

TEXTURE0, TEXTURE_2D, TEXTURE_3D, CUBE_MAP, RGBA8, RGBA, UNSIGNED_BYTE = 0x84C0, 0x0DE1, 0x806F, 0x8513, 0x8058, 0x1908, 0x1401
COLOR_ATTACHMENT0, FRAMEBUFFER, DRAW_FRAMEBUFFER, READ_FRAMEBUFFER, RENDERBUFFER = 0x8CE0, 0x8D40, 0x8CA9, 0x8CA8, 0x8D41
BUFFERS = {
    "array": (0x8892, 0x8894), "element": (0x8893, 0x8895), "pack": (0x88EB, 0x88ED), "unpack": (0x88EC, 0x88EF),
    "uniform": (0x8A11, 0x8A28), "copy read": (0x8F36, 0x8F36), "copy write": (0x8F37, 0x8F37), "feedback": (0x8C8E, 0x8C8F),
}  # fmt: skip
CAPS = {
    "BLEND": 0x0BE2, "CULL_FACE": 0x0B44, "DEPTH_TEST": 0x0B71, "DITHER": 0x0BD0, "POLYGON_OFFSET_FILL": 0x8037,
    "PRIMITIVE_RESTART_FIXED_INDEX": 0x8D69, "RASTERIZER_DISCARD": 0x8C89, "SAMPLE_ALPHA_TO_COVERAGE": 0x809E,
    "SAMPLE_COVERAGE": 0x80A0, "SCISSOR_TEST": 0x0C11, "STENCIL_TEST": 0x0B90,
}  # fmt: skip
DESKTOP_CAPS = {
    "PRIMITIVE_RESTART": 0x8F9D, "FRAMEBUFFER_SRGB": 0x8DB9, "MULTISAMPLE": 0x809D, "DEPTH_CLAMP": 0x864F,
    "COLOR_LOGIC_OP": 0x0BF2, "PROGRAM_POINT_SIZE": 0x8642, "POLYGON_SMOOTH": 0x0B41, "LINE_SMOOTH": 0x0B20,
    "POLYGON_OFFSET_LINE": 0x2A02, "SAMPLE_ALPHA_TO_ONE": 0x809F, "SAMPLE_MASK": 0x8E51, "CUBE_SEAMLESS": 0x884F,
    "CLIP_DISTANCE0": 0x3000, "CLIP_DISTANCE3": 0x3003,
}  # fmt: skip
INTEGERS = {
    "program": (0x8B8D, 1), "vertex array": (0x85B5, 1), "renderbuffer": (0x8CA7, 1), "draw framebuffer": (0x8CA6, 1),
    "read framebuffer": (0x8CAA, 1), "viewport": (0x0BA2, 4), "scissor": (0x0C10, 4), "color mask": (0x0C23, 4),
    "depth mask": (0x0B72, 1), "depth func": (0x0B74, 1), "cull mode": (0x0B45, 1), "front face": (0x0B46, 1),
    "blend src rgb": (0x80C9, 1), "blend dst rgb": (0x80C8, 1), "blend src a": (0x80CB, 1), "blend dst a": (0x80CA, 1),
    "blend eq rgb": (0x8009, 1), "blend eq a": (0x883D, 1), "stencil func": (0x0B92, 1), "stencil ref": (0x0B97, 1),
    "stencil value mask": (0x0B93, 1), "stencil writemask": (0x0B98, 1), "stencil fail": (0x0B94, 1),
    "stencil back func": (0x8800, 1), "stencil back writemask": (0x8CA5, 1), "stencil clear": (0x0B91, 1),
    "pack alignment": (0x0D05, 1), "pack row length": (0x0D02, 1), "pack skip rows": (0x0D03, 1), "pack skip": (0x0D04, 1),
    "unpack alignment": (0x0CF5, 1), "unpack row length": (0x0CF2, 1), "unpack skip rows": (0x0CF3, 1),
    "unpack skip": (0x0CF4, 1), "unpack image height": (0x806E, 1), "unpack skip images": (0x806D, 1),
    "sample coverage invert": (0x80AB, 1), "derivative hint": (0x8B8B, 1), "feedback active": (0x8E24, 1),
    "feedback paused": (0x8E23, 1), "read buffer": (0x0C02, 1), **{f"draw buffer {i}": (0x8825 + i, 1) for i in range(4)},
}  # fmt: skip
DESKTOP_INTEGERS = {
    "polygon mode": (0x0B40, 1), "provoking vertex": (0x8E4F, 1), "logic op": (0x0BF0, 1), "restart index": (0x8F9E, 1),
    "swap pack": (0x0D00, 1), "swap unpack": (0x0CF0, 1),
    "clip origin": (0x935C, 1), "clip depth": (0x935D, 1),
}  # fmt: skip
FLOATS = {
    "clear color": (0x0C22, 4), "clear depth": (0x0B73, 1), "depth range": (0x0B70, 2), "blend color": (0x8005, 4),
    "offset factor": (0x8038, 1), "offset units": (0x2A00, 1), "sample coverage": (0x80AA, 1), "line width": (0x0B21, 1),
}  # fmt: skip
DESKTOP_INDEXED = {"viewport": 0x0BA2, "scissor": 0x0C10, "mask": 0x0C23, "src": 0x80C9, "dst": 0x80C8, "eq": 0x8009}


def units(ctx: Context) -> list[int]:
    return [*range(8), ctx.functions.integers(0x8872)[0] - 1]


def everything(ctx: Context) -> dict[str, Any]:
    """All the state that OpenGL tells, by name."""
    gl, desktop = ctx.functions, ctx.api == "gl"
    is_enabled = gl("glIsEnabled", B, U)
    state: dict[str, Any] = {n: bool(is_enabled(cap)) for n, cap in (CAPS | (DESKTOP_CAPS if desktop else {})).items()}
    for name, (pname, count) in (INTEGERS | (DESKTOP_INTEGERS if desktop else {})).items():
        state[name] = gl.integers(pname, count)
    floats = (F * 4)()
    for name, (pname, count) in FLOATS.items():
        gl("glGetFloatv", None, U, P)(pname, ctypes.addressof(floats))
        state[name] = list(floats[:count])
    state.update({f"{name} buffer": gl.integers(pname) for name, (_, pname) in BUFFERS.items()})
    indexed, value = gl("glGetIntegeri_v", None, U, U, P), (I * 4)()
    pairs = {f"uniform buffer {i}": (0x8A28, i) for i in range(3)}
    if desktop:
        pairs |= {f"{name} {i}": (pname, i) for name, pname in DESKTOP_INDEXED.items() for i in range(4)}
        pairs["sample mask"] = (0x8E52, 0)
        state["enabled"] = [bool(gl("glIsEnabledi", B, U, U)(cap, i)) for cap in (0x0BE2, 0x0C11) for i in range(4)]
    for name, (pname, i) in pairs.items():
        indexed(pname, i, ctypes.addressof(value))
        state[name] = list(value)
    state["active texture"] = gl.integers(0x84E0)
    for unit in units(ctx):
        gl("glActiveTexture", None, U)(TEXTURE0 + unit)
        state[f"unit {unit}"] = [gl.integers(pname)[0] for pname in (0x8069, 0x806A, 0x8514, 0x8919)]
    gl("glActiveTexture", None, U)(state["active texture"][0])
    return state


def generate(ctx: Context, kind: str, count: int) -> list[int]:
    names = (U * count)()
    ctx.functions(f"glGen{kind}", None, I, P)(count, ctypes.addressof(names))
    return list(names)


def texture(ctx: Context, w: int = 8, h: int = 8) -> None:
    ctx.functions("glTexImage2D", None, U, I, I, I, I, I, U, U, P)(TEXTURE_2D, 0, RGBA8, w, h, 0, RGBA, UNSIGNED_BYTE, None)


def disturb(ctx: Context) -> None:
    """Set every state to something that no pass expects. The objects made here live as long as the context."""
    gl, desktop = ctx.functions, ctx.api == "gl"
    _bind_everything(ctx)
    for name, cap in (CAPS | (DESKTOP_CAPS if desktop else {})).items():
        gl("glDisable" if name in ("DITHER", "MULTISAMPLE") else "glEnable", None, U)(cap)
    gl("glBlendFuncSeparate", None, U, U, U, U)(0x0306, 0x0305, 0x0302, 0x0304)
    gl("glBlendEquationSeparate", None, U, U)(0x800A, 0x800B)
    gl("glBlendColor", None, F, F, F, F)(0.5, 0.25, 0.125, 0.75)
    gl("glColorMask", None, B, B, B, B)(0, 1, 0, 1)
    gl("glDepthMask", None, B)(1)
    gl("glDepthFunc", None, U)(0x0200)
    gl("glStencilFunc", None, U, I, U)(0x0200, 5, 0xF0)
    gl("glStencilOp", None, U, U, U)(0x1E02, 0x1E03, 0x150A)
    gl("glStencilMask", None, U)(0x3C)
    gl("glClearColor", None, F, F, F, F)(0.125, 0.25, 0.5, 0.75)
    gl("glClearDepthf", None, F)(0.5)
    gl("glClearStencil", None, I)(7)
    gl("glViewport", None, I, I, I, I)(3, 5, 7, 11)
    gl("glScissor", None, I, I, I, I)(1, 2, 3, 4)
    gl("glDepthRangef", None, F, F)(0.75, 0.25)
    gl("glCullFace", None, U)(0x0408)
    gl("glFrontFace", None, U)(0x0900)
    gl("glPolygonOffset", None, F, F)(2, 3)
    gl("glSampleCoverage", None, F, B)(0.25, 1)
    gl("glHint", None, U, U)(0x8B8B, 0x1102)
    for pname, value in (
        (0x0D05, 1), (0x0D02, 17), (0x0D03, 2), (0x0D04, 3), (0x0CF5, 2), (0x0CF2, 19), (0x0CF3, 4), (0x0CF4, 5),
        (0x806E, 6), (0x806D, 1),
    ):  # fmt: skip
        gl("glPixelStorei", None, U, I)(pname, value)
    if desktop:
        _disturb_desktop(ctx)
    assert ctx.mgl.error == "GL_NO_ERROR"


def _disturb_desktop(ctx: Context) -> None:
    gl = ctx.functions
    gl("glPolygonMode", None, U, U)(0x0408, 0x1B01)
    gl("glProvokingVertex", None, U)(0x8E4D)
    gl("glLogicOp", None, U)(0x1500)
    gl("glPrimitiveRestartIndex", None, U)(7)
    gl("glSampleMaski", None, U, U)(0, 0)
    gl("glPixelStorei", None, U, I)(0x0D00, 1)
    gl("glPixelStorei", None, U, I)(0x0CF0, 1)
    gl("glClipControl", None, U, U)(0x8CA2, 0x935F)
    gl("glDisablei", None, U, U)(0x0BE2, 1)
    gl("glColorMaski", None, U, B, B, B, B)(2, 1, 0, 1, 0)
    gl("glBlendFuncSeparatei", None, U, U, U, U, U)(1, 1, 0, 1, 1)
    gl("glBlendEquationi", None, U, U)(3, 0x8008)
    gl("glViewportIndexedf", None, U, F, F, F, F)(2, 1.5, 2.5, 3.5, 4.5)
    gl("glScissorIndexed", None, U, I, I, I, I)(1, 9, 8, 7, 6)
    gl("glDisablei", None, U, U)(0x0C11, 3)
    gl("glDepthRangeIndexed", None, U, D, D)(1, 0.125, 0.5)


def _bind_everything(ctx: Context) -> None:
    gl = ctx.functions
    for unit in units(ctx):
        gl("glActiveTexture", None, U)(TEXTURE0 + unit)
        for target in (TEXTURE_2D, TEXTURE_3D, CUBE_MAP):
            gl("glBindTexture", None, U, U)(target, generate(ctx, "Textures", 1)[0])
            if target == TEXTURE_2D:
                texture(ctx)
        sampler = generate(ctx, "Samplers", 1)[0]
        gl("glBindSampler", None, U, U)(unit, sampler)
        gl("glSamplerParameteri", None, U, U, I)(sampler, 0x884C, 0x884E)  # compare: shadow look-ups
    gl("glActiveTexture", None, U)(TEXTURE0 + 5)
    gl("glBindVertexArray", None, U)(generate(ctx, "VertexArrays", 1)[0])
    for target in (READ_FRAMEBUFFER, DRAW_FRAMEBUFFER):
        name = framebuffer(ctx, 2)
        gl("glBindFramebuffer", None, U, U)(target, name)
    gl("glDrawBuffers", None, I, P)(2, ctypes.addressof((U * 2)(0, COLOR_ATTACHMENT0 + 1)))
    gl("glReadBuffer", None, U)(COLOR_ATTACHMENT0 + 1)
    for target, _ in BUFFERS.values():
        gl("glBindBuffer", None, U, U)(target, generate(ctx, "Buffers", 1)[0])
        gl("glBufferData", None, U, ctypes.c_ssize_t, P, U)(target, 64, None, 0x88E4)
    for i in range(3):
        gl("glBindBufferBase", None, U, U, U)(0x8A11, i, generate(ctx, "Buffers", 1)[0])
    gl("glBindRenderbuffer", None, U, U)(RENDERBUFFER, generate(ctx, "Renderbuffers", 1)[0])
    version = "#version 300 es\nprecision highp float;" if ctx.api == "es" else "#version 330"
    program = ctx.mgl.program(
        vertex_shader=f"{version}\nvoid main() {{ gl_Position = vec4(0.0); }}",
        fragment_shader=f"{version}\nout vec4 c; void main() {{ c = vec4(1.0); }}",
    )
    gl("glUseProgram", None, U)(program.glo)


def framebuffer(ctx: Context, attachments: int, size: tuple[int, int] = (8, 8)) -> int:
    """GL name of a complete framebuffer with so many rgba8 textures; stays bound."""
    gl = ctx.functions
    name = generate(ctx, "Framebuffers", 1)[0]
    gl("glBindFramebuffer", None, U, U)(FRAMEBUFFER, name)
    kept = gl.integers(0x8069)[0]
    for i, tex in enumerate(generate(ctx, "Textures", attachments)):
        gl("glBindTexture", None, U, U)(TEXTURE_2D, tex)
        texture(ctx, *size)
        gl("glTexParameteri", None, U, U, I)(TEXTURE_2D, 0x2801, 0x2600)
        gl("glFramebufferTexture2D", None, U, U, U, U, I)(FRAMEBUFFER, COLOR_ATTACHMENT0 + i, TEXTURE_2D, tex, 0)
    gl("glBindTexture", None, U, U)(TEXTURE_2D, kept)
    return name


def alive(ctx: Context, names: int = 400) -> dict[str, int]:
    """How many GL objects of each kind there are, among the first ``names`` names: drivers count up from 1."""
    kinds = ["Texture", "Buffer", "Framebuffer", "Renderbuffer", "Program", "Shader", "Sampler", "VertexArray", "Query"]
    exists = {kind: ctx.functions(f"glIs{kind}", B, U) for kind in kinds}
    return {kind: sum(bool(test(name)) for name in range(1, names)) for kind, test in exists.items()}
