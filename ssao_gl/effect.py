"""The pass for other people's programs: their depth in, visibility or a shaded picture out, their GL state untouched."""

from __future__ import annotations

import os
from collections.abc import Mapping
from types import TracebackType
from typing import Any

import moderngl

from .camera import Camera, Size
from .errors import FormatError, SettingsError
from .gl.context import Context
from .gl.frame import Frame, PassTime
from .gl.kit import FORMATS, Kit
from .gl.providers import wrap_moderngl
from .gl.state import GuestState
from .pipeline import EYE_DEPTH, WINDOW_DEPTH, Settings, plan_apply

Image = moderngl.Texture | int
"""A texture of the caller's: moderngl's object, or the GL name of a 2-D texture."""


class Effect:
    """Ambient occlusion over a depth texture that you rendered.

    ``ctx`` is your moderngl context or one from :func:`ssao_gl.gl.wrap_current`; it must be current at every call.
    ``size`` is (width, height) of your textures, in pixels. Radii are in the units of your depth.

        effect = Effect(ctx, (1280, 720), Settings(method=Alchemy(radius=0.3)))
        visibility = effect.apply(depth=depth_texture, camera=camera)
    """

    def __init__(self, ctx: moderngl.Context | Context, size: Size, settings: Settings | None = None) -> None:
        self.settings = settings or Settings()
        if self.settings.method.radius is None:
            raise SettingsError(f"Effect: give {self.settings.method.name} a radius, in the units of your depth")
        self._ctx = ctx if isinstance(ctx, Context) else wrap_moderngl(ctx)
        self._guest = GuestState(self._ctx)
        self._frames: dict[Any, Frame] = {}
        self._foreign: dict[tuple[int, int], moderngl.Texture] = {}
        self._checked = os.environ.get("SSAO_GL_DEBUG") == "1"
        with self._guest:
            self._kit = Kit(self._ctx)
        self.resize(*size)

    def resize(self, width: int, height: int) -> None:
        """Your textures have another size from now on: frees everything made for the old one. Raises SettingsError."""
        if width < 1 or height < 1:
            raise SettingsError(f"Effect: size {width}x{height}; both must be at least 1 pixel")
        self.size = (int(width), int(height))
        self._drop_frames()

    def apply(
        self,
        *,
        depth: Image,
        camera: Camera,
        color: Image | None = None,
        normal: Image | None = None,
        depth_kind: str = WINDOW_DEPTH,
        target: moderngl.Framebuffer | int | None = None,
        timed: bool = False,
    ) -> moderngl.Texture:
        """Draw the occlusion.

        depth: ``"window"`` (0..1 as a depth buffer holds it, whatever the projection: reversed and infinite too) or ``"eye"``
        (distance along the view axis; 0, inf and nan are background). camera: its projection; the pose is not used.
        color: sRGB texture to be dimmed; without it the result is visibility itself. normal: view-space normals, xyz in
        -1..1; without them they are rebuilt from depth. target: framebuffer of yours (object or GL name) to draw the
        result into.

        Returns the result's texture, owned by the effect and valid until the next call: visibility (r8) or picture (rgba8).
        Every GL state that a pass changes is put back. Raises FormatError for textures of another size.
        """
        output = "visibility" if color is None else "image"
        key = (self.size, depth_kind, normal is not None, output)
        with self._guest:
            frame = self._frames.get(key)
            if frame is None:
                plan = plan_apply(
                    self.settings, self.size, depth=depth_kind, normals=normal is not None, outputs=(output,)
                )
                frame = self._frames[key] = Frame(self._kit, plan)
            given = {"depth": depth, "color": color, "normal_xyz": normal}
            inputs = {name: self._texture(name, image) for name, image in given.items() if image is not None}
            targets = None if target is None else {output: self._framebuffer(target)}
            result = frame.run(
                camera.view(self.size), inputs, targets=targets, timed=timed, checked=self._checked
            )
            self.times: list[PassTime] = frame.times
        return result[output]

    def describe(self, depth_kind: str = WINDOW_DEPTH, *, normal: bool = False, color: bool = True) -> str:
        """The plan as text: passes, formats, slots, MiB, what was left out and why."""
        output = "image" if color else "visibility"
        return plan_apply(self.settings, self.size, depth=depth_kind, normals=normal, outputs=(output,)).describe()

    def _texture(self, name: str, image: Image) -> moderngl.Texture:
        if isinstance(image, int):
            texture = self._foreign.get((image, 0))
            if texture is None or texture.size != self.size:
                # Components and type do not matter here: the texture is only bound, never read or written by moderngl.
                texture = self._ctx.mgl.external_texture(image, self.size, 4, 0, "f1")
                self._foreign[(image, 0)] = texture
            return texture
        if image.size != self.size:
            raise FormatError(f"Effect: the {name} texture is {image.size[0]}x{image.size[1]}, the effect {self.size[0]}x{self.size[1]}; call resize")
        return image

    def _framebuffer(self, target: moderngl.Framebuffer | int) -> moderngl.Framebuffer:
        if isinstance(target, int):
            return self._ctx.mgl.detect_framebuffer(target)
        return target

    def _drop_frames(self) -> None:
        for frame in self._frames.values():
            frame.release()
        self._frames = {}
        self._foreign = {}

    def release(self) -> None:
        """Free every GL object that the effect made. Calling it twice does no harm."""
        with self._guest:
            self._drop_frames()
            self._kit.release()

    def __enter__(self) -> Effect:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()


def upload(kit: Kit, name: str, array: Any) -> moderngl.Texture:
    """An array (h, w, c), row 0 on top, as a texture: uint8 as rgba8, else 32-bit floats."""
    import numpy as np

    from .images import flipped

    h, w = array.shape[:2]
    channels = 1 if array.ndim == 2 else array.shape[2]
    dtype = "f1" if array.dtype == np.uint8 else "f4"
    data = flipped(array if dtype == "f1" else array.astype(np.float32))
    texture = kit.ctx.mgl.texture((w, h), channels, data.tobytes(), alignment=1, dtype=dtype)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture


__all__ = ["EYE_DEPTH", "FORMATS", "WINDOW_DEPTH", "Effect", "Mapping", "upload"]
