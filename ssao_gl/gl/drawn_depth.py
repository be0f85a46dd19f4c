"""What a G-buffer holds already, as a texture by which vertex shaders leave out what it hides."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..scene.ball_culling import LEVELS, farthest_depths
from .programs import GpuResources


class DrawnDepth:
    """The farthest depths of a target; see :func:`~ssao_gl.scene.ball_culling.farthest_depths`."""

    def __init__(self, resources: GpuResources) -> None:
        self._resources = resources
        self._texture: moderngl.Texture | None = None
        self._size = (0, 0)

    def update(self, depth: NDArray[np.float32]) -> None:
        """Take the linear depth (h, w) of a target, 0 where nothing is drawn, row 0 at the bottom."""
        levels = farthest_depths(depth)
        size = levels.shape[::-1]
        if self._texture is None or self._texture.size != size:
            self.release()
            self._texture = self._resources.ctx.mgl.texture(size, 1, dtype="f4")
            self._texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._texture.write(levels)
        self._size = depth.shape[::-1]

    def bound(self, unit: int) -> dict[str, Any]:
        """Bind the texture to a unit, and return the uniforms of shaders with ``DRAWN``."""
        assert self._texture is not None, "no depth was taken yet"
        self._resources.bind(unit, self._texture)
        return {"u_drawn": unit, "u_drawn_size": self._size, "u_levels": LEVELS}

    def release(self) -> None:
        """Free the texture."""
        if self._texture is not None:
            self._texture.release()
        self._texture = None
