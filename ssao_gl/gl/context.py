"""An OpenGL context that ssao_gl can draw with: moderngl's context, the raw functions beside it, and what it can do."""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

import moderngl

from ..errors import ContextError, one_line
from .guest_state import GlState
from .loader import Functions, GetProc, Loader
from .ownership import Ownership, software_turns
from .process import check_process, note_renderer, return_freed_memory

Api = Literal["es", "gl"]

GL_VENDOR, GL_RENDERER, GL_VERSION, GL_EXTENSIONS, GL_NUM_EXTENSIONS = 0x1F00, 0x1F01, 0x1F02, 0x1F03, 0x821D
GL_MAX_TEXTURE_SIZE, GL_MAJOR_VERSION = 0x0D33, 0x821B
SOFTWARE = ("llvmpipe", "softpipe", "swiftshader", "software", "swrast", "lavapipe")


@dataclass
class Context:
    """One OpenGL (ES) context. ``release`` it, or leave a ``with`` block.

    What ssao_gl opened by EGL or OSMesa may be used in any thread, one at a time; others stay in the thread that made them.
    """

    provider: str
    platform: str
    api: Api
    mgl: moderngl.Context
    functions: Functions
    loader: Loader | None = None
    make_current: Callable[[], Callable[[], None]] | None = None
    """Returns what makes current again whatever was before, be it nothing. None: the caller makes it current."""
    close: Callable[[], None] = lambda: None
    """Destroys what :func:`ssao_gl.gl.open` made; does nothing for a context of the caller."""
    leave: Callable[[], None] = lambda: None
    """Makes current again what was before :func:`ssao_gl.gl.open`, if anything was."""
    ownership: Ownership = field(default_factory=Ownership)
    version: str = field(init=False)
    renderer: str = field(init=False)
    max_size: int = field(init=False)
    """Largest width or height of a texture, in pixels. Asked here, where the context is current."""
    released: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        self.version = self.functions.string(GL_VERSION)
        self.renderer = self.functions.string(GL_RENDERER)
        note_renderer(self.renderer)
        if self.software:
            self.ownership.lock = software_turns(os.getpid())
        self.max_size = self.functions.integers(GL_MAX_TEXTURE_SIZE)[0]

    def __enter__(self) -> Context:
        return self

    def __exit__(self, *exception: object) -> None:
        self.release()

    def release(self) -> None:
        """Destroy the context if ssao_gl made it. Calling it twice does no harm, nor does calling it in a forked child."""
        if self.ownership.inherited:
            self.released = True
            return
        with self.ownership.lock:
            if not self.released:
                self.released = True
                self.close()
                return_freed_memory()

    @contextmanager
    def current(self) -> Iterator[None]:
        """Within the block this context is current, and other threads wait for it; after it, whichever one was before.

        Raises ContextError in a thread or process that cannot use it, and for what OpenGL refuses to make.
        """
        if self.make_current is None:
            with self.callers():
                yield
            return
        with self.ownership.held(), self._refusals():
            if self.released:
                raise ContextError("the OpenGL context was released; make another")
            try:
                back = self.make_current()
            except OSError as reason:
                raise ContextError(
                    f"{self.provider}: {reason}. Is it current in another thread? Make one Renderer a thread"
                ) from None
            try:
                yield
            finally:
                back()

    @contextmanager
    def callers(self) -> Iterator[None]:
        """Within the block the context is used where the caller has made it current. Raises ContextError like :meth:`current`."""
        with self.ownership.held(self._is_any_current), self._refusals():
            yield

    def _is_any_current(self) -> bool:
        return bool(self.functions.integers(GL_MAJOR_VERSION)[0])

    @contextmanager
    def _refusals(self) -> Iterator[None]:
        try:
            yield
        except moderngl.Error as error:
            raise ContextError(f"{self.renderer} ({self.provider}): {one_line(error)}") from error

    @property
    def software(self) -> bool:
        """Whether the CPU draws. Then GL timers mean nothing and the wall clock is used."""
        return any(word in self.renderer.lower() for word in SOFTWARE)

    @property
    def gpu_timer(self) -> bool:
        """Whether GL's own timer can be trusted. Software renderers answer it with nonsense (llvmpipe: 9 microseconds for 500)."""
        return not self.software and (self.api == "gl" or "GL_EXT_disjoint_timer_query" in self.extensions())

    @property
    def dialect(self) -> str:
        """The shader dialect that this context compiles."""
        return "es300" if self.api == "es" else "gl330"

    @property
    def blends_floats(self) -> bool:
        """Whether colours of 32-bit float targets can be added up; those of half floats can everywhere."""
        return self.api == "gl" or "GL_EXT_float_blend" in self.extensions()

    def extensions(self) -> frozenset[str]:
        """Names of all extensions."""
        get = self.functions("glGetStringi", ctypes.c_char_p, ctypes.c_uint, ctypes.c_uint)
        count = self.functions.integers(GL_NUM_EXTENSIONS)[0]
        return frozenset((get(GL_EXTENSIONS, i) or b"").decode("ascii", "replace") for i in range(count))

    def check_error(self, where: str) -> None:
        """Raise ContextError when OpenGL has recorded an error since the last check; ``where`` names the work done."""
        error = self.mgl.error
        if error != "GL_NO_ERROR":
            raise ContextError(f"{where}: OpenGL reports {error} ({self.provider}, {self.renderer})")
        if self.loader and self.loader.absent_calls:
            names = ", ".join(dict.fromkeys(self.loader.absent_calls))
            raise ContextError(f"{where}: called {names}, which this OpenGL does not have ({self.provider}, {self.version})")


def attach(
    provider: str,
    platform: str,
    get_proc: GetProc,
    *,
    api: Api | None = None,
    make_current: Callable[[], Callable[[], None]] | None = None,
    close: Callable[[], None] = lambda: None,
    leave: Callable[[], None] = lambda: None,
) -> Context:
    """Return a :class:`Context` over whatever context is current, its functions found by ``get_proc``.

    Raises ContextError when nothing is current or the version is too old (OpenGL ES 3.0 or OpenGL 3.3 is needed).
    """
    check_process()
    functions = Functions(get_proc)
    if not get_proc("glGetString"):
        raise ContextError("get_proc finds no glGetString: is it the right function for this context?")
    text = functions.string(GL_VERSION)
    if not text:
        raise ContextError("no OpenGL context is current in this thread; make it current first")
    found: Api = "es" if "OpenGL ES" in text else "gl"
    number = re.search(r"(\d+)\.(\d+)", text)
    version = int(number[1]) * 100 + int(number[2]) * 10 if number else 0
    if api is not None and api != found:
        raise ContextError(f"the current context is '{text}', not {'OpenGL ES' if api == 'es' else 'desktop OpenGL'}")
    if version < (300 if found == "es" else 330):
        raise ContextError(f"'{text}' is too old: OpenGL ES 3.0 or OpenGL 3.3 is needed")
    if not functions.integers(GL_MAJOR_VERSION)[0]:  # some drivers tell their version without a context
        raise ContextError("no OpenGL context is current in this thread; make it current first")
    loader = Loader(functions, es=found == "es", version=version)
    # Making moderngl's context changes blending, primitive restart and bindings, which may be the caller's.
    state = GlState(functions, es=found == "es", version=version)
    before, made = state.snapshot(), state.made_by_moderngl()
    mgl = moderngl.create_context(require=300, context=loader)  # type: ignore[arg-type]
    state.restore(before)
    state.restore_made_by_moderngl(made)
    context = Context(provider, platform, found, mgl, functions, loader, make_current, close, leave)
    context.ownership.rebinds = make_current is not None
    if found == "es":
        _need_float_targets(context)
    context.check_error("opening the context")
    return context


def _need_float_targets(context: Context) -> None:
    """Linear depth is a 32-bit float target; ES 3.0 has those by an extension that nearly all drivers offer."""
    if "EXT_color_buffer_float" not in " ".join(context.extensions()) and not context.version.startswith("OpenGL ES 3.2"):
        raise ContextError(f"{context.renderer} ({context.version}) lacks EXT_color_buffer_float, which linear depth needs")
