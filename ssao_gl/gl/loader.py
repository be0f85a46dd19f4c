"""The object that moderngl asks for GL entry points, and what it is told on true OpenGL ES.

moderngl asks once for every entry point it knows and calls some that OpenGL ES does not have. Since the
loader hands out addresses, it can hand out small callbacks for those: unmodified moderngl then runs on ES.
"""

from __future__ import annotations

import ctypes
import logging
from collections.abc import Callable
from typing import Any

log = logging.getLogger("ssao_gl.gl")

GetProc = Callable[[str], int]
"""name of a GL function -> its address, 0 when absent."""

# moderngl tests these for NULL before it calls them, so absence must stay visible.
OPTIONAL = frozenset(
    [
        "glPrimitiveRestartIndex",
        "glObjectLabel",
        "glGetObjectLabel",
        "glLabelObjectEXT",
        "glGetObjectLabelEXT",
        "glPushDebugGroup",
        "glPopDebugGroup",
        "glPushGroupMarkerEXT",
        "glPopGroupMarkerEXT",
    ]
)

ENABLES_ES_LACKS = frozenset({0x884F, 0x8F9D, 0x8642, 0x809D})
"""TEXTURE_CUBE_MAP_SEAMLESS, PRIMITIVE_RESTART, PROGRAM_POINT_SIZE, MULTISAMPLE."""

DRAW_BUFFER, DRAW_BUFFER0 = 0x0C01, 0x8825
DEPTH_COMPONENT, DEPTH_COMPONENT24, DEPTH_COMPONENT32F, FLOAT = 0x1902, 0x81A6, 0x8CAC, 0x1406
VIEWPORT, FRAMEBUFFER, COLOR_ATTACHMENT0, FRAMEBUFFER_BINDING = 0x0BA2, 0x8D40, 0x8CE0, 0x8CA6
TEXTURE_WIDTH, TEXTURE_HEIGHT, TEXTURE_2D, TEXTURE_BINDING_2D = 0x1000, 0x1001, 0x0DE1, 0x8069

I, U, F, D, P, B = ctypes.c_int, ctypes.c_uint, ctypes.c_float, ctypes.c_double, ctypes.c_void_p, ctypes.c_ubyte


class Functions:
    """GL functions of the current context, called through ctypes: ``gl("glGetIntegerv", None, U, P)(pname, address)``."""

    def __init__(self, get_proc: GetProc) -> None:
        self.get_proc = get_proc
        self._cache: dict[str, Any] = {}

    def __call__(self, name: str, result: Any, *arguments: Any) -> Any:
        function = self._cache.get(name)
        if function is None:
            address = self.get_proc(name)
            if not address:
                return None
            function = self._cache[name] = ctypes.CFUNCTYPE(result, *arguments)(address)
        return function

    def integers(self, pname: int, count: int = 1) -> list[int]:
        """``glGetIntegerv``."""
        values = (I * 16)()
        self("glGetIntegerv", None, U, P)(pname, ctypes.addressof(values))
        return list(values[:count])

    def string(self, pname: int) -> str:
        """``glGetString``; empty when the driver has none."""
        text = self("glGetString", ctypes.c_char_p, U)(pname)
        return text.decode("utf-8", "replace") if text else ""


class Loader:
    """What ``moderngl.create_context(context=...)`` wants: entry points, and a context to enter and leave."""

    def __init__(self, functions: Functions, *, es: bool, version: int) -> None:
        self.functions = functions
        self.absent_calls: list[str] = []
        """Names of absent functions that moderngl called all the same; empty on a healthy run."""
        self._callbacks: dict[str, Any] = _es_shims(functions, version) if es else {}
        self._es = es

    def load_opengl_function(self, name: str) -> int:
        """Address of the GL function ``name``, of a shim, or of a recorder that notes the call; 0 only where that is safe."""
        if name in self._callbacks:
            callback = self._callbacks[name]
            return ctypes.cast(callback, P).value or 0 if callback else 0
        address = self.functions.get_proc(name)
        if address or name in OPTIONAL or not name.startswith("gl"):
            return address
        return ctypes.cast(self._recorder(name), P).value or 0

    def _recorder(self, name: str) -> Any:
        def record() -> int:
            self.absent_calls.append(name)
            log.error("%s is absent in this OpenGL%s", name, " ES" if self._es else "")
            return 0

        callback = self._callbacks[name] = ctypes.CFUNCTYPE(ctypes.c_size_t)(record)
        return callback

    def __enter__(self) -> None:
        return None

    def __exit__(self, *exception: object) -> None:
        return None

    def release(self) -> None:
        """moderngl calls this; the context belongs to :class:`ssao_gl.gl.Context`."""


def _es_shims(gl: Functions, version: int) -> dict[str, Any]:
    """Callbacks for the calls of moderngl that OpenGL ES lacks or defines otherwise. None may raise."""

    def clear_depth(value: float) -> None:
        gl("glClearDepthf", None, F)(value)

    def depth_range(near: float, far: float) -> None:
        gl("glDepthRangef", None, F, F)(near, far)

    def draw_buffer(mode: int) -> None:
        gl("glDrawBuffers", None, I, P)(1, ctypes.byref(U(mode)))

    def color_mask_indexed(index: int, r: int, g: int, b: int, a: int) -> None:
        if index == 0:  # without the indexed form all targets share one mask
            gl("glColorMask", None, B, B, B, B)(r, g, b, a)

    def enable(cap: int) -> None:
        if cap not in ENABLES_ES_LACKS:
            gl("glEnable", None, U)(cap)

    def disable(cap: int) -> None:
        if cap not in ENABLES_ES_LACKS:
            gl("glDisable", None, U)(cap)

    def get_integer(pname: int, out: int) -> None:
        gl("glGetIntegerv", None, U, P)(DRAW_BUFFER0 if pname == DRAW_BUFFER else pname, out)

    def ignore(*_: int) -> None:
        return None

    shims: dict[str, Any] = {
        "glClearDepth": ctypes.CFUNCTYPE(None, D)(clear_depth),
        "glDepthRange": ctypes.CFUNCTYPE(None, D, D)(depth_range),
        "glDrawBuffer": ctypes.CFUNCTYPE(None, U)(draw_buffer),
        "glClampColor": ctypes.CFUNCTYPE(None, U, U)(ignore),
        "glPolygonMode": ctypes.CFUNCTYPE(None, U, U)(ignore),
        "glProvokingVertex": ctypes.CFUNCTYPE(None, U)(ignore),
        "glPointSize": ctypes.CFUNCTYPE(None, F)(ignore),
        "glBindFragDataLocation": ctypes.CFUNCTYPE(None, U, U, P)(ignore),
        "glPrimitiveRestartIndex": None,  # moderngl then enables PRIMITIVE_RESTART_FIXED_INDEX, which ES has
        "glEnable": ctypes.CFUNCTYPE(None, U)(enable),
        "glDisable": ctypes.CFUNCTYPE(None, U)(disable),
        "glGetIntegerv": ctypes.CFUNCTYPE(None, U, P)(get_integer),
        **_texture_shims(gl, version),
    }
    # By version, not by address: ANGLE hands out functions that it then refuses.
    if version < 320 or not gl.get_proc("glColorMaski"):
        shims["glColorMaski"] = ctypes.CFUNCTYPE(None, U, B, B, B, B)(color_mask_indexed)
    return shims


def _texture_shims(gl: Functions, version: int) -> dict[str, Any]:
    """Callbacks for those that make, measure and read textures."""

    def tex_image_2d(
        target: int, level: int, internal: int, w: int, h: int, border: int, format_: int, type_: int, data: int | None
    ) -> None:
        if internal == DEPTH_COMPONENT24 and type_ == FLOAT:  # an illegal pair in ES 3; 32F keeps the data valid
            internal = DEPTH_COMPONENT32F
        gl("glTexImage2D", None, U, I, I, I, I, I, U, U, P)(target, level, internal, w, h, border, format_, type_, data)

    def get_tex_image(target: int, level: int, format_: int, type_: int, pixels: int) -> None:
        if target == TEXTURE_2D:
            _read_texture(gl, level, format_, type_, pixels)

    def tex_level_parameter(target: int, level: int, pname: int, out: int) -> None:
        size = gl.integers(VIEWPORT, 4)[2:]
        value = {TEXTURE_WIDTH: size[0], TEXTURE_HEIGHT: size[1]}.get(pname, 0)
        ctypes.cast(out, ctypes.POINTER(I))[0] = value

    shims: dict[str, Any] = {
        "glTexImage2D": ctypes.CFUNCTYPE(None, U, I, I, I, I, I, U, U, P)(tex_image_2d),
        "glGetTexImage": ctypes.CFUNCTYPE(None, U, I, U, U, P)(get_tex_image),
    }
    if version < 310 or not gl.get_proc("glGetTexLevelParameteriv"):
        shims["glGetTexLevelParameteriv"] = ctypes.CFUNCTYPE(None, U, I, U, P)(tex_level_parameter)
    return shims


def _read_texture(gl: Functions, level: int, format_: int, type_: int, pixels: int) -> None:
    """``glGetTexImage`` of a colour texture by way of a framebuffer: ES has only ``glReadPixels``."""
    texture = gl.integers(TEXTURE_BINDING_2D)[0]
    bound = gl.integers(FRAMEBUFFER_BINDING)[0]
    width, height = I(), I()
    query = gl("glGetTexLevelParameteriv", None, U, I, U, P)
    if query is None:
        log.error("reading a texture needs OpenGL ES 3.1; read a framebuffer instead")
        return
    query(TEXTURE_2D, level, TEXTURE_WIDTH, ctypes.addressof(width))
    query(TEXTURE_2D, level, TEXTURE_HEIGHT, ctypes.addressof(height))
    framebuffer = U()
    gl("glGenFramebuffers", None, I, P)(1, ctypes.addressof(framebuffer))
    gl("glBindFramebuffer", None, U, U)(FRAMEBUFFER, framebuffer.value)
    attach = gl("glFramebufferTexture2D", None, U, U, U, U, I)
    attach(FRAMEBUFFER, COLOR_ATTACHMENT0, TEXTURE_2D, texture, level)
    gl("glReadPixels", None, I, I, I, I, U, U, P)(0, 0, width.value, height.value, format_, type_, pixels)
    gl("glBindFramebuffer", None, U, U)(FRAMEBUFFER, bound)
    gl("glDeleteFramebuffers", None, I, P)(1, ctypes.addressof(framebuffer))
