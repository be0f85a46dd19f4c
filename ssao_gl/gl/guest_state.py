"""The GL state of a program that ssao_gl is a guest in: saved before our passes, put back after them.

Saved is what passes and moderngl change, and nothing else: setting the rest again would lose what the plain calls of
OpenGL cannot express (a blend function for each draw buffer, a depth range for each viewport).
"""

from __future__ import annotations

import ctypes
from types import TracebackType
from typing import TYPE_CHECKING, Any

from .loader import Functions

if TYPE_CHECKING:
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
    "COLOR_LOGIC_OP": 0x0BF2, "PROGRAM_POINT_SIZE": 0x8642, "POLYGON_SMOOTH": 0x0B41, "SAMPLE_ALPHA_TO_ONE": 0x809F,
    "TEXTURE_CUBE_MAP_SEAMLESS": 0x884F, **{f"CLIP_DISTANCE{i}": 0x3000 + i for i in range(8)},
}  # fmt: skip
SAMPLE_MASK, SAMPLE_SHADING = 0x8E51, 0x8C36
KEPT = frozenset({"MULTISAMPLE", "TEXTURE_CUBE_MAP_SEAMLESS"})
"""Capabilities that do not matter to our passes and are left as they are."""

ACTIVE_TEXTURE, TEXTURE0, TEXTURE_2D, TEXTURE_BINDING_2D, SAMPLER_BINDING = 0x84E0, 0x84C0, 0x0DE1, 0x8069, 0x8919
CURRENT_PROGRAM, VERTEX_ARRAY, ARRAY_BUFFER, RENDERBUFFER = 0x8B8D, 0x85B5, 0x8892, 0x8D41
ARRAY_BUFFER_BINDING, RENDERBUFFER_BINDING = 0x8894, 0x8CA7
PIXEL_PACK_BUFFER, PIXEL_UNPACK_BUFFER, PIXEL_PACK_BINDING, PIXEL_UNPACK_BINDING = 0x88EB, 0x88EC, 0x88ED, 0x88EF
DRAW_FRAMEBUFFER, READ_FRAMEBUFFER, DRAW_FRAMEBUFFER_BINDING, READ_FRAMEBUFFER_BINDING = 0x8CA9, 0x8CA8, 0x8CA6, 0x8CAA
VIEWPORT, COLOR_MASK, DEPTH_MASK, DEPTH_FUNC, MAX_VIEWPORTS, MAX_DRAW_BUFFERS, MAX_IMAGE_UNITS = (
    0x0BA2, 0x0C23, 0x0B72, 0x0B74, 0x825B, 0x8824, 0x8872,
)  # fmt: skip
BLEND_SRC_RGB, BLEND_DST_RGB, BLEND_SRC_A, BLEND_DST_A = 0x80C9, 0x80C8, 0x80CB, 0x80CA
POLYGON_MODE, FRONT_AND_BACK, FILL = 0x0B40, 0x0408, 0x1B02
CLIP_ORIGIN, CLIP_DEPTH_MODE, LOWER_LEFT, NEGATIVE_ONE_TO_ONE = 0x935C, 0x935D, 0x8CA1, 0x935E
FEEDBACK_PAUSED, FEEDBACK_ACTIVE, RESTART_INDEX = 0x8E23, 0x8E24, 0x8F9E
PIXEL_STORE = {
    "PACK_ALIGNMENT": 0x0D05, "PACK_ROW_LENGTH": 0x0D02, "PACK_SKIP_ROWS": 0x0D03, "PACK_SKIP_PIXELS": 0x0D04,
    "UNPACK_ALIGNMENT": 0x0CF5, "UNPACK_ROW_LENGTH": 0x0CF2, "UNPACK_SKIP_ROWS": 0x0CF3, "UNPACK_SKIP_PIXELS": 0x0CF4,
    "UNPACK_SKIP_IMAGES": 0x806D,  # not for 2-D textures, says the standard; SwiftShader does it
}  # fmt: skip
DESKTOP_PIXEL_STORE = {
    "PACK_SWAP_BYTES": 0x0D00,
    "PACK_LSB_FIRST": 0x0D01,
    "UNPACK_SWAP_BYTES": 0x0CF0,
    "UNPACK_LSB_FIRST": 0x0CF1,
}
NEUTRAL_STORE = {"PACK_ALIGNMENT": 4, "UNPACK_ALIGNMENT": 4}
BINDINGS = {
    "program": CURRENT_PROGRAM, "vertex array": VERTEX_ARRAY, "array buffer": ARRAY_BUFFER_BINDING,
    "renderbuffer": RENDERBUFFER_BINDING, "pack buffer": PIXEL_PACK_BINDING, "unpack buffer": PIXEL_UNPACK_BINDING,
    "draw framebuffer": DRAW_FRAMEBUFFER_BINDING, "read framebuffer": READ_FRAMEBUFFER_BINDING, "depth mask": DEPTH_MASK,
    "active texture": ACTIVE_TEXTURE, "depth function": DEPTH_FUNC,
}  # fmt: skip

State = dict[str, Any]
"""Values of GL state by name."""


class GlState:
    """The part of the state of a context that drawing with ssao_gl changes. ``version``: 320 for 3.2."""

    def __init__(self, functions: Functions, *, es: bool, version: int) -> None:
        self._gl = gl = functions
        self._es = es
        # Asked some 80 times a frame: looked up once, into memory that is made once.
        self._values = (I * 16)()
        self._at = ctypes.addressof(self._values)
        self._get = gl("glGetIntegerv", None, U, P)
        self._is_enabled = gl("glIsEnabled", B, U)
        self._is_enabled_at = gl("glIsEnabledi", B, U, U)
        self._activate = gl("glActiveTexture", None, U)
        self._caps = CAPABILITIES | ({} if es else DESKTOP_CAPABILITIES)
        if version >= (310 if es else 330):
            self._caps = {**self._caps, "SAMPLE_MASK": SAMPLE_MASK}
        if version >= (320 if es else 400):
            self._caps = {**self._caps, "SAMPLE_SHADING": SAMPLE_SHADING}
        self._store = PIXEL_STORE | ({} if es else DESKTOP_PIXEL_STORE)
        # By version, not by address: some drivers hand out functions that they then refuse.
        self._buffers = gl.integers(MAX_DRAW_BUFFERS)[0] if not es or version >= 320 else 0
        self._viewports = gl.integers(MAX_VIEWPORTS)[0] if not es and version >= 410 else 0
        self._blends = self._buffers if es or version >= 400 else 0
        self._clip_control = not es and version >= 450 and bool(gl.get_proc("glClipControl"))
        self._feedback = es or version >= 400
        # moderngl makes textures on the last unit, whatever is bound there.
        last = min(gl.integers(MAX_IMAGE_UNITS)[0], 32) - 1
        self._units = (*range(UNITS), *((last,) if last >= UNITS else ()))

        counts = {"BLEND": self._buffers, "SCISSOR_TEST": self._viewports}
        self._counts = {name: counts.get(name, 0) for name in self._caps}

    def _integer(self, pname: int) -> int:
        self._get(pname, self._at)
        return self._values[0]

    def _capability(self, cap: int, count: int) -> tuple[int, ...]:
        """Whether it is on: one value, or one for each of ``count`` draw buffers or viewports."""
        if not count:
            return (self._is_enabled(cap),)
        is_enabled = self._is_enabled_at
        return tuple([is_enabled(cap, i) for i in range(count)])

    def _indexed(self, pname: int, index: int) -> int:
        value = (I * 4)()
        self._gl("glGetIntegeri_v", None, U, U, P)(pname, index, ctypes.addressof(value))
        return int(value[0])

    def snapshot(self) -> State:
        """Every value that a pass could change, by name."""
        one, counts = self._integer, self._counts
        state: State = {name: self._capability(cap, counts[name]) for name, cap in self._caps.items()}
        for table in (BINDINGS, self._store):
            for name, pname in table.items():
                state[name] = one(pname)
        units = []
        for unit in self._units:
            self._activate(TEXTURE0 + unit)
            units.append((one(TEXTURE_BINDING_2D), one(SAMPLER_BINDING)))
        self._activate(state["active texture"])
        state["textures and samplers"] = units
        state["viewports"] = self._viewport_values()
        state["color masks"] = self._color_masks()
        if not self._es:
            state["polygon mode"] = one(POLYGON_MODE)
        if self._clip_control:
            state["clip control"] = (one(CLIP_ORIGIN), one(CLIP_DEPTH_MODE))
        if self._feedback:
            state["feedback runs"] = bool(one(FEEDBACK_ACTIVE) and not one(FEEDBACK_PAUSED))
        return state

    def _viewport_values(self) -> tuple[float, ...]:
        if not self._viewports:
            self._get(VIEWPORT, self._at)
            return tuple(self._values[:4])
        values = (F * (4 * self._viewports))()
        get = self._gl("glGetFloati_v", None, U, U, P)
        for i in range(self._viewports):
            get(VIEWPORT, i, ctypes.addressof(values) + 16 * i)
        return tuple(values)

    def _color_masks(self) -> tuple[tuple[int, ...], ...]:
        if not self._buffers:
            self._get(COLOR_MASK, self._at)
            return (tuple(self._values[:4]),)
        mask, get = (B * 4)(), self._gl("glGetBooleani_v", None, U, U, P)
        masks = []
        for i in range(self._buffers):
            get(COLOR_MASK, i, ctypes.addressof(mask))
            masks.append(tuple(mask))
        return tuple(masks)

    def neutral(self, saved: State) -> None:
        """Set what our passes expect; ``saved`` is what is set now."""
        gl = self._gl
        if saved.get("feedback runs"):
            gl("glPauseTransformFeedback", None)()
        disable = gl("glDisable", None, U)
        for name, cap in self._caps.items():
            if name not in KEPT and any(saved[name]):
                disable(cap)
        gl("glColorMask", None, B, B, B, B)(1, 1, 1, 1)
        store = gl("glPixelStorei", None, U, I)
        for name, pname in self._store.items():
            store(pname, NEUTRAL_STORE.get(name, 0))
        bind = gl("glBindBuffer", None, U, U)
        bind(PIXEL_PACK_BUFFER, 0)
        bind(PIXEL_UNPACK_BUFFER, 0)
        if not self._es:
            gl("glPolygonMode", None, U, U)(FRONT_AND_BACK, FILL)
        if self._clip_control:
            gl("glClipControl", None, U, U)(LOWER_LEFT, NEGATIVE_ONE_TO_ONE)

    def restore(self, saved: State) -> None:
        """Set every value of a snapshot."""
        gl = self._gl
        for name, cap in self._caps.items():
            self._restore_capability(cap, saved[name])
        bind, sampler = gl("glBindTexture", None, U, U), gl("glBindSampler", None, U, U)
        is_texture = gl("glIsTexture", B, U)
        for unit, (texture, sampled_by) in zip(self._units, saved["textures and samplers"], strict=True):
            self._activate(TEXTURE0 + unit)
            # An effect's result, which the caller may have bound, may be gone by now; its name is not to be made anew.
            bind(TEXTURE_2D, texture if texture and is_texture(texture) else 0)
            sampler(unit, sampled_by)
        self._activate(saved["active texture"])
        gl("glUseProgram", None, U)(saved["program"])
        gl("glBindVertexArray", None, U)(saved["vertex array"])
        bind_buffer = gl("glBindBuffer", None, U, U)
        bind_buffer(ARRAY_BUFFER, saved["array buffer"])
        bind_buffer(PIXEL_PACK_BUFFER, saved["pack buffer"])
        bind_buffer(PIXEL_UNPACK_BUFFER, saved["unpack buffer"])
        gl("glBindRenderbuffer", None, U, U)(RENDERBUFFER, saved["renderbuffer"])
        framebuffer = gl("glBindFramebuffer", None, U, U)
        framebuffer(DRAW_FRAMEBUFFER, saved["draw framebuffer"])
        framebuffer(READ_FRAMEBUFFER, saved["read framebuffer"])
        self._restore_viewports(saved["viewports"])
        self._restore_color_masks(saved["color masks"])
        gl("glDepthMask", None, B)(saved["depth mask"])
        gl("glDepthFunc", None, U)(saved["depth function"])
        store = gl("glPixelStorei", None, U, I)
        for name, pname in self._store.items():
            store(pname, saved[name])
        if not self._es:
            gl("glPolygonMode", None, U, U)(FRONT_AND_BACK, saved["polygon mode"])
        if self._clip_control:
            gl("glClipControl", None, U, U)(*saved["clip control"])
        if saved.get("feedback runs"):  # last: it needs its own program to be current
            gl("glResumeTransformFeedback", None)()

    def _restore_capability(self, cap: int, on: tuple[int, ...]) -> None:
        gl = self._gl
        gl("glEnable" if on[0] else "glDisable", None, U)(cap)
        if len(set(on)) > 1:
            for i, value in enumerate(on):
                gl("glEnablei" if value else "glDisablei", None, U, U)(cap, i)

    def _restore_viewports(self, values: tuple[float, ...]) -> None:
        if self._viewports:
            array = (F * len(values))(*values)
            self._gl("glViewportArrayv", None, U, I, P)(0, self._viewports, ctypes.addressof(array))
        else:
            self._gl("glViewport", None, I, I, I, I)(*map(int, values))

    def _restore_color_masks(self, masks: tuple[tuple[int, ...], ...]) -> None:
        self._gl("glColorMask", None, B, B, B, B)(*masks[0])
        if len(set(masks)) > 1:
            for i, mask in enumerate(masks):
                self._gl("glColorMaski", None, U, B, B, B, B)(i, *mask)

    def made_by_moderngl(self) -> State:
        """Return what no pass changes, but the making of a moderngl context does: blending and the index of primitive
        restart."""
        names = (BLEND_SRC_RGB, BLEND_DST_RGB, BLEND_SRC_A, BLEND_DST_A)
        count = self._blends
        blend = [[self._indexed(p, i) for p in names] for i in range(count)] or [[self._gl.integers(p)[0] for p in names]]
        return {"blend": blend} | ({} if self._es else {"restart index": U(self._gl.integers(RESTART_INDEX)[0]).value})

    def restore_made_by_moderngl(self, saved: State) -> None:
        """Undo the making of a moderngl context."""
        blend = saved["blend"]
        self._gl("glBlendFuncSeparate", None, U, U, U, U)(*blend[0])
        for i, values in enumerate(blend):
            if values != blend[0]:
                self._gl("glBlendFuncSeparatei", None, U, U, U, U, U)(i, *values)
        if not self._es:
            self._gl("glPrimitiveRestartIndex", None, U)(saved["restart index"])


class GuestState:
    """``with GuestState(ctx):`` saves the caller's state, sets a neutral one, and puts everything back at the end."""

    def __init__(self, ctx: Context) -> None:
        self._mgl = ctx.mgl
        self._screen = ctx.mgl.detect_framebuffer(0)
        self._state = GlState(ctx.functions, es=ctx.api == "es", version=ctx.mgl.version_code)

    def snapshot(self) -> State:
        """Every value that a pass could change, by name."""
        return self._state.snapshot()

    def __enter__(self) -> GuestState:
        self._saved = self._state.snapshot()
        # moderngl keeps its own record of what is bound, once in Python and once in C.
        self._record = self._mgl.fbo, self._mgl.mglo.fbo
        # It goes back to that one whenever it makes something, and the caller may have deleted it since.
        self._mgl.fbo, self._mgl.mglo.fbo = self._screen, self._screen.mglo
        self._state.neutral(self._saved)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._mgl.fbo, self._mgl.mglo.fbo = self._record
        self._state.restore(self._saved)
