"""What is kept from one frame of a sequence to the next, all of it: put away and read again, the sequence goes on with the same bytes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from ..gl.programs import GpuResources
from ..io.atomic import atomic_write
from ..passes.temporal import PHASES, Moment
from ..scene.camera import Camera
from ..scene.projection import Size, ViewConstants

Matrix = NDArray[np.float64]


class History:
    """The frames of a sequence so far, of one size, settings and scene. A new one begins a new sequence, as a cut in a film does.

    state: (h, w, 4) float32 of the last frame with its guard band, row 0 on top, at the size at which it is averaged: visibility,
    number of frames, linear depth, 0; None before the first. frame: number of the next one. moved: whether things moved since the last frame; see
    :class:`~ssao_gl.passes.temporal.Moment`.
    """

    def __init__(self) -> None:
        self.frame = 0
        self.moved = False
        self.state: NDArray[np.float32] | None = None
        self._pose: Matrix = np.eye(4)
        self._projection: Matrix = np.eye(4)

    @property
    def moment(self) -> Moment:
        """The next frame, as plans know it."""
        return Moment(self.frame % PHASES, self.moved)

    def given(self, size: Size) -> NDArray[np.float32]:
        """Return what the last frame left for a frame of that size; nothing where that is another one."""
        w, h = size
        fits = self.state is not None and self.state.shape == (h, w, 4)
        return self.state if fits and self.state is not None else np.zeros((h, w, 4), np.float32)

    def uniforms(self, camera: Camera) -> dict[str, Any]:
        """Return the uniforms of ``temporal.frag`` that are this frame's: where in the last one its points were."""
        return reprojection(camera.pose, self._projection, self._pose)

    def keep(self, state: NDArray[np.float32] | None, view: ViewConstants, camera: Camera) -> None:
        """Take the frame that was drawn for the last one."""
        self.state, self._pose, self._projection = state, np.array(camera.pose, np.float64), view.projection
        self.frame += 1

    def save(self, path: Path) -> None:
        """Write all of it to a file."""
        state = np.zeros((0, 0, 4), np.float32) if self.state is None else self.state
        with atomic_write(path) as temporary, temporary.open("wb") as file:
            np.savez(file, frame=self.frame, state=state, pose=self._pose, projection=self._projection)

    @classmethod
    def load(cls, path: Path) -> History:
        """Read what :meth:`save` wrote. Raises FormatError."""
        made = cls()
        try:
            with np.load(path, allow_pickle=False) as found:
                made.frame, state = int(found["frame"]), found["state"]
                made._pose, made._projection = found["pose"], found["projection"]
        except (OSError, ValueError, KeyError, EOFError) as error:
            raise FormatError(f"{path}: not the history of a sequence ({type(error).__name__})") from None
        made.state = state if state.size else None
        return made


class TextureHistory:
    """The same on the GPU, for programs that draw: the last frame's state in a texture that stays."""

    def __init__(self, resources: GpuResources) -> None:
        self._past = History()
        self._resources = resources
        self._made: tuple[moderngl.Texture, moderngl.Framebuffer] | None = None

    def begin(self, *, moved: bool) -> Moment:
        """Return the next frame."""
        self._past.moved = moved
        return self._past.moment

    def textures(self, size: Size) -> tuple[moderngl.Texture, moderngl.Framebuffer]:
        """Return the texture of the last frame's state, of the size that all frames have, and the framebuffer that writes it."""
        if self._made is None:
            texture = self._resources.upload(self._past.given(size))
            self._made = texture, self._resources.ctx.mgl.framebuffer([texture])
        return self._made

    def uniforms(self, camera: Camera) -> dict[str, Any]:
        """Return its uniforms; see :meth:`History.uniforms`."""
        return self._past.uniforms(camera)

    def end(self, view: ViewConstants, camera: Camera) -> None:
        """Take the frame that was drawn, and copied into the texture, for the last one."""
        self._past.keep(None, view, camera)

    def release(self) -> None:
        """Free both GL objects."""
        for made in reversed(self._made or ()):
            made.release()


def reprojection(pose: Matrix, projection: Matrix, before: Matrix) -> dict[str, Any]:
    """Return uniforms that bring points in view space under ``pose`` to the clip space and linear depth under the pose ``before``."""
    to_view = np.linalg.inv(before) @ pose
    clip = projection @ to_view
    return {"u_to_previous": tuple(clip.T.ravel()), "u_previous_depth": tuple(-to_view[2])}
