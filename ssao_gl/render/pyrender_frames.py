"""pyrender's ``OffscreenRenderer`` with the same calls, drawn by ssao_gl: a script gets occlusion by another import."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError, warn_of_input
from ..gl.context import Context
from ..loaders.pyrender_scenes import camera_from_pyrender, from_pyrender
from ..pipeline.settings import Settings
from .renderer import Renderer

DEPTH_ONLY, SHADOWS, RGBA, FLAT, SEG = 1, 32 | 64 | 128, 2048, 4096, 8192
LINES = {4: "FLIP_WIREFRAME", 8: "ALL_WIREFRAME", 256: "VERTEX_NORMALS", 512: "FACE_NORMALS"}
"""Flags of ``pyrender.RenderFlags``, which are numbers. OFFSCREEN, ALL_SOLID and SKIP_CULL_FACES hold always."""

Frame = tuple[NDArray[np.uint8], NDArray[np.float32]] | NDArray[np.float32]


class OffscreenRenderer:
    """``pyrender.OffscreenRenderer`` with ambient occlusion.

        renderer = ssao_gl.OffscreenRenderer(640, 480)
        color, depth = renderer.render(scene)

    viewport_width, viewport_height: pixels. settings: method, filter, light. ``point_size`` is taken and not used: points close their surface.
    """

    def __init__(
        self,
        viewport_width: int,
        viewport_height: int,
        point_size: float = 1.0,
        *,
        settings: Settings | None = None,
        provider: str | Context = "auto",
    ) -> None:
        self.viewport_width, self.viewport_height, self.point_size = viewport_width, viewport_height, point_size
        self.settings = settings or Settings()
        self._renderer = Renderer(provider, keep=4)

    def render(self, scene: Any, flags: int = 0, seg_node_map: Mapping[Any, Any] | None = None) -> Frame:
        """Draw a ``pyrender.Scene`` through its main camera.

        flags, of ``pyrender.RenderFlags``: RGBA gives four channels, FLAT leaves the light out (occlusion stays), DEPTH_ONLY gives
        depth alone; SEG gives the colours of ``seg_node_map`` (node -> one number or three, 0 to 255) as they are, on black,
        without other nodes; SHADOWS_* are not drawn, with a warning. Returns colour (h, w, 3 or 4) uint8 sRGB and depth
        (h, w) float32, distance along the view axis, 0 = background. Raises SettingsError for what draws lines, and for SEG without a
        map; SceneError.
        """
        if wrong := [name for bit, name in LINES.items() if flags & bit]:
            raise SettingsError(f"flags: {', '.join(wrong)} draws lines, which ssao_gl does not; leave it out")
        if flags & SHADOWS:
            warn_of_input("flags: SHADOWS_* are left out; ssao_gl draws no cast shadows")
        if flags & SEG and seg_node_map is None:
            raise SettingsError("flags: SEG needs seg_node_map, colours by node")
        drawn = from_pyrender(scene, painted=seg_node_map if flags & SEG else None)
        aov = "color" if flags & SEG else "image"
        wanted = ("depth",) if flags & DEPTH_ONLY else (aov, "depth")
        picture = self._renderer.render(
            drawn, camera_from_pyrender(scene), (self.viewport_width, self.viewport_height), self._lit(flags), aovs=wanted
        )
        if flags & DEPTH_ONLY:
            return picture.depth
        color = picture.arrays[aov]
        if flags & SEG:
            color = np.where(picture.depth[..., None] > 0, color, np.uint8(0))
        return _channels(color, 4 if flags & RGBA else 3), picture.depth

    def _lit(self, flags: int) -> Settings:
        if not flags & FLAT:
            return self.settings
        return dataclasses.replace(self.settings, shading=dataclasses.replace(self.settings.shading, ambient=1.0))

    def delete(self) -> None:
        """Free all resources."""
        self._renderer.release()

    def __enter__(self) -> OffscreenRenderer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.delete()


def _channels(color: NDArray[np.uint8], count: int) -> NDArray[np.uint8]:
    """Return colour with 3 or 4 channels, opaque where it had no alpha."""
    if color.shape[2] >= count:
        return np.ascontiguousarray(color[..., :count])
    return np.concatenate([color, np.full((*color.shape[:2], 1), 255, np.uint8)], -1)
