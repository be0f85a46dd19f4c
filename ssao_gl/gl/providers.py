"""Where an OpenGL context can come from: a table of providers, each giving a context or the reason why not."""

from __future__ import annotations

import ctypes
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import moderngl

from ..errors import ContextError, SettingsError, near_miss
from . import egl, osmesa
from .context import Api, Context, attach
from .loader import GetProc
from .ownership import software_turns
from .process import check_process


@dataclass(frozen=True, slots=True)
class Provider:
    """A way to a context. ``open`` returns it or raises OSError, ImportError or ContextError with the reason."""

    name: str
    summary: str
    cure: str
    open: Callable[[], Context]


def _from_egl(name: str, opened: egl.EglContext, api: Api | None) -> Context:
    try:
        return attach(
            name,
            opened.platform,
            opened.get_proc,
            api=api,
            make_current=opened.make_current,
            close=opened.release,
            leave=opened.leave,
        )
    except BaseException:
        opened.release()
        opened.leave()
        raise


def _egl_es() -> Context:
    library = egl.Egl()
    return _from_egl("egl-es", egl.open_context(library, egl.displays(library), es=True), "es")


def _egl_gl() -> Context:
    library = egl.Egl()
    return _from_egl("egl-gl", egl.open_context(library, egl.displays(library), es=False), "gl")


def _osmesa() -> Context:
    return _from_egl("osmesa", osmesa.open_context(), "gl")


def _angle() -> Context:
    if importlib.util.find_spec("comfy_angle") is None:
        raise ImportError("the package comfy-angle is not installed")
    import comfy_angle

    library = egl.Egl(comfy_angle.get_egl_path(), comfy_angle.get_glesv2_path())
    with _silent():  # ANGLE writes to the terminal where it finds no Vulkan; the reason is in the error as well
        opened = egl.open_context(library, egl.angle_display(library), es=True)
    return _from_egl("angle", opened, "es")


@contextmanager
def _silent() -> Iterator[None]:
    """Send standard error of the whole process, libraries in C too, nowhere."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def _swiftshader() -> Context:
    spec = importlib.util.find_spec("kaleido")
    if spec is None or not spec.submodule_search_locations:
        raise ImportError("the package kaleido 0.2.1, which carries SwiftShader, is not installed")
    folder = Path(spec.submodule_search_locations[0]) / "executable" / "bin" / "swiftshader"
    suffix = ".dll" if sys.platform == "win32" else ".so"
    if not (folder / f"libEGL{suffix}").exists():
        raise ImportError("this kaleido carries no SwiftShader; version 0.2.1 does")
    library = egl.Egl(str(folder / f"libEGL{suffix}"), str(folder / f"libGLESv2{suffix}"))
    display = library.function("eglGetDisplay", ctypes.c_void_p, ctypes.c_void_p)(None)
    return _from_egl("swiftshader", egl.open_context(library, iter([("default display", display)]), es=True), "es")


def _native() -> Context:
    """moderngl's own off-screen context: the way on macOS and Windows."""
    try:
        mgl = moderngl.create_context(standalone=True, require=330)
    except Exception as error:  # glcontext raises bare Exception
        raise OSError(str(error)) from error
    try:
        return wrap_moderngl(mgl, provider="native", close=mgl.release)
    except BaseException:
        mgl.release()
        raise


_SOFTWARE_EXTRA = "pip install 'ssao_gl[software]'"
_APT_EGL = "install a driver: apt-get install libegl1 libgl1-mesa-dri"

PROVIDERS: Mapping[str, Provider] = {
    provider.name: provider
    for provider in (
        Provider("egl-es", "OpenGL ES 3 by the system's EGL", _APT_EGL, _egl_es),
        Provider("egl-gl", "OpenGL core by the system's EGL", _APT_EGL, _egl_gl),
        Provider("osmesa", "OpenGL core by OSMesa", "apt-get install libosmesa6", _osmesa),
        Provider("angle", "OpenGL ES 3 by ANGLE", "pip install comfy-angle, and a Vulkan driver", _angle),
        Provider("swiftshader", "OpenGL ES 3 by SwiftShader, on the CPU", _SOFTWARE_EXTRA, _swiftshader),
        Provider("native", "OpenGL core by moderngl's own window-system context", "run it in a desktop session", _native),
    )
}
"""In the order in which ``auto`` tries them."""


def open_context(provider: str = "auto", *, api: Api | None = None) -> Context:
    """Open the named provider's context, or the first that works (of ``api`` "es" or "gl", where that matters).

    Raises SettingsError for an unknown name and ContextError, with every reason and cure, when none opens.
    """
    if provider != "auto" and provider not in PROVIDERS:
        names = ", ".join(["auto", *PROVIDERS])
        raise SettingsError(f"unknown provider of OpenGL '{provider}'; there are {names}.{near_miss(provider, PROVIDERS)}")
    tried = list(PROVIDERS.values()) if provider == "auto" else [PROVIDERS[provider]]
    check_process()
    reasons = []
    for candidate in tried:
        try:
            with software_turns(os.getpid()):
                context = candidate.open()
            if api in (None, context.api):
                return context
            context.release()
            reasons.append(f"  {candidate.name:12}gives {context.version}, not {api}")
        except (OSError, ImportError, AttributeError, ContextError) as reason:
            reasons.append(f"  {candidate.name:12}{reason}")
    cures = dict.fromkeys(candidate.cure for candidate in tried)
    raise ContextError("no OpenGL could be opened.\n" + "\n".join(reasons) + "\nTry: " + "   or   ".join(cures))


def wrap_current(get_proc: GetProc | None = None, *, api: Api | None = None) -> Context:
    """Use the context that is current in this thread, made by somebody else. Nothing is created and nothing is destroyed.

    ``get_proc`` maps a GL function name to its address (``eglGetProcAddress`` and its kin, as an int); without it the
    usual libraries are searched for the one that has a current context. ``api`` ("es" or "gl") only checks.
    """
    check_process()
    return attach("current", "the caller's", get_proc or find_get_proc(), api=api)


def wrap_moderngl(mgl: moderngl.Context, *, provider: str = "current", close: Callable[[], None] = lambda: None) -> Context:
    """Use a moderngl context of the caller; it must be current. Raises ContextError when it cannot be used."""
    from .loader import Functions, Loader

    check_process()
    if not isinstance(mgl, moderngl.Context):
        raise ContextError(f"expected a moderngl.Context or a context of ssao_gl.gl, got {type(mgl).__name__}")
    # What moderngl loaded its own functions with knows the right library, wherever the context came from.
    origin = getattr(mgl.mglo, "_context", None)
    if isinstance(origin, Loader):
        functions = origin.functions
        api: Api = "es" if "OpenGL ES" in functions.string(0x1F02) else "gl"
        return Context(provider, "the caller's", api, mgl, functions, origin, close=close)
    functions = Functions(getattr(origin, "load_opengl_function", None) or find_get_proc())
    if "OpenGL ES" in functions.string(0x1F02):
        raise ContextError("moderngl by itself does not run on OpenGL ES; make it with ssao_gl.gl.wrap_current() instead")

    def make_current() -> Callable[[], None]:
        mgl.__enter__()  # type: ignore[no-untyped-call]
        return lambda: mgl.__exit__(None, None, None)  # type: ignore[no-untyped-call]

    return Context(provider, "the caller's", "gl", mgl, functions, None, make_current, close)


def find_get_proc() -> GetProc:
    """Return the ``get_proc`` of whichever library has a current context in this thread: EGL, GLX, WGL, OSMesa or macOS."""
    if sys.platform == "darwin":
        return _exports(ctypes.CDLL("/System/Library/Frameworks/OpenGL.framework/OpenGL"))
    if sys.platform == "win32":
        return _windows_get_proc()
    for library, current, get in (
        ("libEGL.so.1", "eglGetCurrentContext", "eglGetProcAddress"),
        ("libGLX.so.0", "glXGetCurrentContext", "glXGetProcAddressARB"),
        ("libGL.so.1", "glXGetCurrentContext", "glXGetProcAddressARB"),
        ("libOSMesa.so.8", "OSMesaGetCurrentContext", "OSMesaGetProcAddress"),
    ):
        try:
            lib = ctypes.CDLL(library)
            has_current, address = getattr(lib, current), getattr(lib, get)
        except (OSError, AttributeError):
            continue
        has_current.restype, has_current.argtypes = ctypes.c_void_p, []
        address.restype, address.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
        if has_current():
            return lambda name, address=address: address(name.encode()) or 0  # type: ignore[misc]
    raise ContextError("no OpenGL context is current in this thread; make it current, or pass get_proc")


def _exports(lib: ctypes.CDLL) -> GetProc:
    def address(name: str) -> int:
        found = getattr(lib, name, None)
        return 0 if found is None else ctypes.cast(found, ctypes.c_void_p).value or 0

    return address


def _windows_get_proc() -> GetProc:
    """wglGetProcAddress knows all but the functions of OpenGL 1.1, which opengl32.dll exports."""
    lib = ctypes.CDLL(os.path.join(os.environ.get("SystemRoot", r"C:\Windows"), "System32", "opengl32.dll"))  # noqa: PTH118
    exported = _exports(lib)
    lib.wglGetProcAddress.restype, lib.wglGetProcAddress.argtypes = ctypes.c_void_p, [ctypes.c_char_p]

    def address(name: str) -> int:
        found = lib.wglGetProcAddress(name.encode()) or 0
        return found if found > 3 and found != 2**64 - 1 else exported(name)

    return address
