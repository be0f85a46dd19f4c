"""The pass for other people's programs: their depth in, visibility or a shaded picture out, their GL state untouched."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import Any, SupportsIndex

import moderngl

from ..errors import ContextError, FormatError, SettingsError
from ..gl.clearing import DrawTarget
from ..gl.context import Context
from ..gl.executor import FrameExecutor
from ..gl.external import GuestFramebuffer, texture_size
from ..gl.frame_cache import FrameCache
from ..gl.guest_state import GuestState
from ..gl.programs import GpuResources
from ..gl.providers import wrap_moderngl
from ..gl.timer import PassTime
from ..graph.names import COLOR, GIVEN_DEPTH, GIVEN_HISTORY, GIVEN_NORMAL, HISTORY, IMAGE, VISIBILITY
from ..graph.plan import Plan
from ..passes.temporal import Moment
from ..pipeline.build import WINDOW_DEPTH, check_camera, plan_apply
from ..pipeline.residual import check_no_scene
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.projection import Size, pixel_size
from .history import TextureHistory

MOST_LAYOUTS = 4
"""Kinds of call (with and without colour, normals, ...) whose textures stay."""

_Key = tuple[Settings, Size, str, bool, str, Moment | None]

SHOWN = {GIVEN_DEPTH: "depth", COLOR: "color", GIVEN_NORMAL: "normal"}
"""Resource -> what the argument is called."""

Image = moderngl.Texture | SupportsIndex
"""A texture of the caller's: moderngl's object, or the GL name of a 2-D texture."""


class Effect:
    """Ambient occlusion over a depth texture that you rendered.

    ``ctx`` is your moderngl context or one from :func:`ssao_gl.gl.wrap_current`; it must be current at every call.
    ``size`` is (width, height) of your textures, in pixels. Radii are in the units of your depth.

        effect = Effect(ctx, (1280, 720), Settings(method=Alchemy(radius=0.3)))
        visibility = effect.apply(depth=depth_texture, camera=camera)

    Your GL state is as you left it after every call, also when it raises. (What OpenGL gives no way to ask or to pause must
    be off: conditional rendering, queries that count samples.)
    """

    def __init__(self, ctx: moderngl.Context | Context, size: Size, settings: Settings | None = None) -> None:
        self._settings = _with_radius(settings or Settings())
        self.size = _checked_size(*pixel_size(size))
        self._ctx = ctx if isinstance(ctx, Context) else wrap_moderngl(ctx)
        self._guest = GuestState(self._ctx)
        self._named: dict[int, moderngl.Texture] = {}
        self._kept: TextureHistory | None = None
        self._debug = os.environ.get("SSAO_GL_DEBUG") == "1"
        self.times: Sequence[PassTime] = ()
        """Milliseconds of each pass of the last call that was ``timed``."""
        with self._used():
            self._resources = GpuResources(self._ctx)
            self._frames: FrameCache[_Key] | None = FrameCache(self._resources, MOST_LAYOUTS)

    @property
    def settings(self) -> Settings:
        """Method, blur and shading; may be set between calls. Raises SettingsError when the method has no radius."""
        return self._settings

    @settings.setter
    def settings(self, settings: Settings) -> None:
        settings = _with_radius(settings)
        if self._frames is not None:
            kept = {self._plan(settings, *key[2:]).layout for key in self._frames.keys}
            with self._used():
                self._frames.retain(kept)
            self.cut()
        self._settings = settings

    def resize(self, width: int, height: int) -> None:
        """Your textures have another size from now on: frees everything made for the old one. Raises SettingsError."""
        size = _checked_size(width, height)
        if self._frames is not None:
            self.cut()
            with self._used():
                self._frames.clear()
        self.size = size

    def apply(
        self,
        *,
        depth: Image,
        camera: Camera,
        color: Image | None = None,
        normal: Image | None = None,
        depth_kind: str = WINDOW_DEPTH,
        target: moderngl.Framebuffer | SupportsIndex | None = None,
        timed: bool = False,
        history: bool = False,
        moved: bool = False,
    ) -> moderngl.Texture:
        """Draw the occlusion. Textures are moderngl's objects or GL names.

        depth: ``"window"`` (0..1 as a depth buffer holds it, whatever the projection: reversed and infinite too) or ``"eye"``
        (distance along the view axis; 0, inf and nan are background). camera: its projection; the pose is used with history alone.
        color: sRGB values (rgba8, not srgb8_alpha8) to be dimmed; without it the result is visibility itself. normal:
        view-space normals, xyz in -1..1; without them they are rebuilt from depth. target: a framebuffer of yours to draw
        the result into as well, at its lower left corner (0: the window). history: average visibility over the calls that ask for it,
        along what is seen, by depth and pose; :meth:`cut` begins anew. moved: things moved in the world since the last of them.

        Returns the result's texture, owned by the effect and valid until the next call: visibility (r8) or picture (rgba8).
        Raises FormatError for textures of another size or kind, and for a target that shows ``color`` itself.
        """
        output = VISIBILITY if color is None else IMAGE
        given = {GIVEN_DEPTH: depth, COLOR: color, GIVEN_NORMAL: normal}
        view = camera.view(self.size)
        check_camera(self.settings, view)
        with ExitStack() as stack:
            stack.enter_context(self._used())
            inputs = {name: self._texture(SHOWN[name], image) for name, image in given.items() if image is not None}
            copies: dict[str, DrawTarget] = {}
            if target is not None:
                read = () if color is None else (inputs[COLOR].glo,)
                copies[output] = stack.enter_context(GuestFramebuffer(self._ctx, self._framebuffer(target), self.size, read))
            past = self._past() if history else None
            moment = None if past is None else past.begin(moved=moved)
            frame = self._frame(depth_kind, normal is not None, output, moment)
            if past is not None:
                before, after = past.textures(frame.plan.size_of(HISTORY))
                inputs, copies = {**inputs, GIVEN_HISTORY: before}, {**copies, HISTORY: after}
            then = None if past is None else past.uniforms(camera)
            drawn = frame.run(view, inputs, copies=copies, moment=then, timed=timed, checked=self._debug)
            if past is not None:
                past.end(view, camera)
            if timed:
                self.times = drawn.times
        return drawn.outputs[output]

    def cut(self) -> None:
        """Begin a new sequence: the next call with history knows nothing of those before. Frees what is kept of them."""
        if self._kept is not None:
            with self._used():
                self._kept.release()
        self._kept = None

    def _past(self) -> TextureHistory:
        self._kept = self._kept or TextureHistory(self._resources)
        return self._kept

    def describe(self, depth_kind: str = WINDOW_DEPTH, *, normal: bool = False, color: bool = True) -> str:
        """Return the plan as text: passes, formats, slots, MiB, what was left out and why."""
        output = IMAGE if color else VISIBILITY
        return self._plan(self.settings, depth_kind, normal, output).describe()

    @contextmanager
    def _used(self) -> Iterator[None]:
        """Use the caller's context and leave its state as it was. Raises ContextError where it is not current, or not this process's."""
        with self._ctx.callers(), self._guest:
            yield

    def _frame(self, depth_kind: str, normals: bool, output: str, moment: Moment | None) -> FrameExecutor:
        if self._frames is None:
            raise ContextError("Effect: was released")

        key: _Key = (self.settings, self.size, depth_kind, normals, output, moment)
        return self._frames.get(key, lambda: self._plan(self.settings, depth_kind, normals, output, moment))

    def _plan(self, settings: Settings, depth_kind: str, normals: bool, output: str, moment: Moment | None = None) -> Plan:
        return plan_apply(settings, self.size, depth=depth_kind, normals=normals, outputs=(output,), moment=moment)

    def _texture(self, name: str, image: Image) -> moderngl.Texture:
        if isinstance(image, moderngl.Texture):
            size: Size | None = image.size
            if image.samples:
                raise FormatError(f"Effect: the {name} texture is multisampled; resolve it first")
        else:
            number = _name(image, f"{name}: expected a moderngl.Texture or a GL name", "; for arrays there is ssao_gl.apply")
            size = texture_size(self._ctx, number)
            image = self._by_name(number)
        if size is not None and size != self.size:
            w, h = self.size
            raise FormatError(f"Effect: the {name} texture is {size[0]}x{size[1]}, the effect {w}x{h}; call resize")
        return image

    def _by_name(self, name: int) -> moderngl.Texture:
        if name not in self._named:
            # Size, components and type do not matter: moderngl only ever binds it. So a name that the caller frees and
            # uses again stays right.
            self._named[name] = self._ctx.mgl.external_texture(name, (1, 1), 4, 0, "f1")
        return self._named[name]

    def _framebuffer(self, target: moderngl.Framebuffer | SupportsIndex) -> int:
        if not isinstance(target, moderngl.Framebuffer):
            return _name(target, "target: expected a moderngl.Framebuffer or a GL name")
        if target.size[0] < self.size[0] or target.size[1] < self.size[1]:
            (w, h), (width, height) = target.size, self.size
            raise FormatError(f"Effect: the target is {w}x{h}, smaller than the effect's {width}x{height}")
        return target.glo

    def release(self) -> None:
        """Free every GL object that the effect made. Calling it twice does no harm."""
        if self._frames is not None and not self._ctx.released and not self._ctx.ownership.inherited:
            self.cut()
            with self._used():
                self._frames.clear()
                self._resources.release()
        self._frames = None

    def __enter__(self) -> Effect:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.release()


def _with_radius(settings: Settings) -> Settings:
    check_no_scene(settings, "Effect")
    if settings.method.radius is None:
        raise SettingsError(f"Effect: give {settings.method.name} a radius, in the units of your depth")
    return settings


def _checked_size(width: int, height: int) -> Size:
    if width < 1 or height < 1:
        raise SettingsError(f"Effect: size {width}x{height}; both must be at least 1 pixel")
    return int(width), int(height)


def _name(value: Any, expected: str, advice: str = "") -> int:
    """Return a GL name from whatever whole number a GL binding gave it as."""
    try:
        return operator.index(getattr(value, "value", value))  # ctypes' numbers keep theirs in .value
    except TypeError:
        raise FormatError(f"Effect: {expected}, got {type(value).__name__}{advice}") from None
