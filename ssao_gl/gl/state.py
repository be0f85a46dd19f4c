"""The GL state of a program that ssao_gl is a guest in: saved before our passes, put back after them."""

from __future__ import annotations

import ctypes
from types import TracebackType

from .context import Context

I, U, F, P, B = ctypes.c_int, ctypes.c_uint, ctypes.c_float, ctypes.c_void_p, ctypes.c_ubyte

UNITS = 8
"""Texture units that our passes may use."""

CAPABILITIES = {
    "BLEND": 0x0BE2, "CULL_FACE": 0x0B44, "DEPTH_TEST": 0x0B71, "DITHER": 0x0BD0, "POLYGON_OFFSET_FILL": 0x8037,
    "PRIMITIVE_RESTART_FIXED_INDEX": 0x8D69, "RASTERIZER_DISCARD": 0x8C89, "SAMPLE_ALPHA_TO_COVERAGE": 0x809E,
    "SAMPLE_COVERAGE": 0x80A0, "SCISSOR_TEST": 0x0C11, "STENCIL_TEST": 0x0B90,
}  # fmt: skip
DESKTOP_CAPABILITIES = {
    "PRIMITIVE_RESTART": 0x8F9D, "FRAMEBUFFER_SRGB": 0x8DB9, "MULTISAMPLE": 0x809D, "DEPTH_CLAMP": 0x864F,
    "COLOR_LOGIC_OP": 0x0BF2, "PROGRAM_POINT_SIZE": 0x8642,
}  # fmt: skip
KEPT_ON = frozenset({"MULTISAMPLE"})

ACTIVE_TEXTURE, TEXTURE0, TEXTURE_2D, TEXTURE_BINDING_2D, SAMPLER_BINDING = 0x84E0, 0x84C0, 0x0DE1, 0x8069, 0x8919
CURRENT_PROGRAM, VERTEX_ARRAY, ARRAY_BUFFER, RENDERBUFFER = 0x8B8D, 0x85B5, 0x8892, 0x8D41
ARRAY_BUFFER_BINDING, RENDERBUFFER_BINDING = 0x8894, 0x8CA7
PIXEL_PACK_BUFFER, PIXEL_UNPACK_BUFFER, PIXEL_PACK_BINDING, PIXEL_UNPACK_BINDING = 0x88EB, 0x88EC, 0x88ED, 0x88EF
DRAW_FRAMEBUFFER, READ_FRAMEBUFFER, DRAW_FRAMEBUFFER_BINDING, READ_FRAMEBUFFER_BINDING = 0x8CA9, 0x8CA8, 0x8CA6, 0x8CAA
VIEWPORT, SCISSOR_BOX, COLOR_CLEAR, DEPTH_CLEAR, COLOR_MASK, DEPTH_MASK, DEPTH_FUNC = (
    0x0BA2, 0x0C10, 0x0C22, 0x0B73, 0x0C23, 0x0B72, 0x0B74,
)  # fmt: skip
BLEND_SRC_RGB, BLEND_DST_RGB, BLEND_SRC_A, BLEND_DST_A, BLEND_EQ_RGB, BLEND_EQ_A = 0x80C9, 0x80C8, 0x80CB, 0x80CA, 0x8009, 0x883D
CULL_MODE, FRONT_FACE, DEPTH_RANGE = 0x0B45, 0x0B46, 0x0B70
PIXEL_STORE = {
    "PACK_ALIGNMENT": 0x0D05, "PACK_ROW_LENGTH": 0x0D02, "PACK_SKIP_ROWS": 0x0D03, "PACK_SKIP_PIXELS": 0x0D04,
    "UNPACK_ALIGNMENT": 0x0CF5, "UNPACK_ROW_LENGTH": 0x0CF2, "UNPACK_SKIP_ROWS": 0x0CF3, "UNPACK_SKIP_PIXELS": 0x0CF4,
}  # fmt: skip
NEUTRAL_STORE = {"PACK_ALIGNMENT": 4, "UNPACK_ALIGNMENT": 4}
LESS = 0x0201


class GuestState:
    """``with GuestState(ctx):`` saves the caller's state, sets a neutral one, and puts everything back at the end."""

    def __init__(self, ctx: Context) -> None:
        self._gl = ctx.functions
        self._mgl = ctx.mgl
        self._caps = CAPABILITIES | (DESKTOP_CAPABILITIES if ctx.api == "gl" else {})

    def snapshot(self) -> dict[str, object]:
        """Every value that a pass could change, by name: what the tests compare."""
        gl, one = self._gl, lambda pname: self._gl.integers(pname)[0]
        is_enabled = gl("glIsEnabled", B, U)
        state: dict[str, object] = {name: bool(is_enabled(cap)) for name, cap in self._caps.items()}
        state["active texture"] = one(ACTIVE_TEXTURE)
        activate = gl("glActiveTexture", None, U)
        for unit in range(UNITS):
            activate(TEXTURE0 + unit)
            state[f"texture {unit}"], state[f"sampler {unit}"] = one(TEXTURE_BINDING_2D), one(SAMPLER_BINDING)
        activate(state["active texture"])
        for name, pname, count in (
            ("program", CURRENT_PROGRAM, 1), ("vertex array", VERTEX_ARRAY, 1), ("array buffer", ARRAY_BUFFER_BINDING, 1),
            ("renderbuffer", RENDERBUFFER_BINDING, 1), ("pack buffer", PIXEL_PACK_BINDING, 1),
            ("unpack buffer", PIXEL_UNPACK_BINDING, 1), ("draw framebuffer", DRAW_FRAMEBUFFER_BINDING, 1),
            ("read framebuffer", READ_FRAMEBUFFER_BINDING, 1), ("viewport", VIEWPORT, 4), ("scissor", SCISSOR_BOX, 4),
            ("color mask", COLOR_MASK, 4), ("depth mask", DEPTH_MASK, 1), ("depth func", DEPTH_FUNC, 1),
            ("cull mode", CULL_MODE, 1), ("front face", FRONT_FACE, 1), ("blend src rgb", BLEND_SRC_RGB, 1),
            ("blend dst rgb", BLEND_DST_RGB, 1), ("blend src a", BLEND_SRC_A, 1), ("blend dst a", BLEND_DST_A, 1),
            ("blend eq rgb", BLEND_EQ_RGB, 1), ("blend eq a", BLEND_EQ_A, 1),
        ):  # fmt: skip
            values = gl.integers(pname, count)
            state[name] = values[0] if count == 1 else tuple(values)
        state.update({name: one(pname) for name, pname in PIXEL_STORE.items()})
        floats = (F * 4)()
        for name, pname, count in (("clear color", COLOR_CLEAR, 4), ("clear depth", DEPTH_CLEAR, 1), ("depth range", DEPTH_RANGE, 2)):
            gl("glGetFloatv", None, U, P)(pname, ctypes.addressof(floats))
            state[name] = tuple(floats[:count])
        return state

    def __enter__(self) -> GuestState:
        self._saved = self.snapshot()
        self._saved_framebuffer = self._mgl.fbo
        self.neutral()
        return self

    def neutral(self) -> None:
        """The state that our passes expect."""
        gl = self._gl
        enable, disable = gl("glEnable", None, U), gl("glDisable", None, U)
        for name, cap in self._caps.items():
            (enable if name in KEPT_ON else disable)(cap)
        gl("glColorMask", None, B, B, B, B)(1, 1, 1, 1)
        gl("glDepthFunc", None, U)(LESS)
        gl("glDepthRangef", None, F, F)(0, 1) if gl("glDepthRangef", None, F, F) else None
        store = gl("glPixelStorei", None, U, I)
        for name, pname in PIXEL_STORE.items():
            store(pname, NEUTRAL_STORE.get(name, 0))
        bind = gl("glBindBuffer", None, U, U)
        bind(PIXEL_PACK_BUFFER, 0)
        bind(PIXEL_UNPACK_BUFFER, 0)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._saved_framebuffer is not None:
            self._saved_framebuffer.use()  # moderngl keeps its own record of what is bound
        self.restore(self._saved)

    def restore(self, state: dict[str, object]) -> None:
        """Set every value of a snapshot."""
        gl, s = self._gl, state
        enable, disable = gl("glEnable", None, U), gl("glDisable", None, U)
        for name, cap in self._caps.items():
            (enable if s[name] else disable)(cap)
        activate, bind, sampler = gl("glActiveTexture", None, U), gl("glBindTexture", None, U, U), gl("glBindSampler", None, U, U)
        for unit in range(UNITS):
            activate(TEXTURE0 + unit)
            bind(TEXTURE_2D, s[f"texture {unit}"])
            sampler(unit, s[f"sampler {unit}"])
        activate(s["active texture"])
        gl("glUseProgram", None, U)(s["program"])
        gl("glBindVertexArray", None, U)(s["vertex array"])
        bind_buffer = gl("glBindBuffer", None, U, U)
        bind_buffer(ARRAY_BUFFER, s["array buffer"])
        bind_buffer(PIXEL_PACK_BUFFER, s["pack buffer"])
        bind_buffer(PIXEL_UNPACK_BUFFER, s["unpack buffer"])
        gl("glBindRenderbuffer", None, U, U)(RENDERBUFFER, s["renderbuffer"])
        framebuffer = gl("glBindFramebuffer", None, U, U)
        framebuffer(DRAW_FRAMEBUFFER, s["draw framebuffer"])
        framebuffer(READ_FRAMEBUFFER, s["read framebuffer"])
        gl("glViewport", None, I, I, I, I)(*s["viewport"])  # type: ignore[misc]
        gl("glScissor", None, I, I, I, I)(*s["scissor"])  # type: ignore[misc]
        gl("glColorMask", None, B, B, B, B)(*s["color mask"])  # type: ignore[misc]
        gl("glDepthMask", None, B)(s["depth mask"])
        gl("glDepthFunc", None, U)(s["depth func"])
        gl("glCullFace", None, U)(s["cull mode"])
        gl("glFrontFace", None, U)(s["front face"])
        gl("glBlendFuncSeparate", None, U, U, U, U)(
            s["blend src rgb"], s["blend dst rgb"], s["blend src a"], s["blend dst a"]
        )
        gl("glBlendEquationSeparate", None, U, U)(s["blend eq rgb"], s["blend eq a"])
        store = gl("glPixelStorei", None, U, I)
        for name, pname in PIXEL_STORE.items():
            store(pname, s[name])
        gl("glClearColor", None, F, F, F, F)(*s["clear color"])  # type: ignore[misc]
        single = gl("glClearDepthf", None, F)
        (single or gl("glClearDepth", None, ctypes.c_double))(s["clear depth"][0])  # type: ignore[index]
        ranged = gl("glDepthRangef", None, F, F)
        (ranged or gl("glDepthRange", None, ctypes.c_double, ctypes.c_double))(*s["depth range"])  # type: ignore[misc]
