"""Where in an image a scene can be seen at all. No OpenGL."""

from __future__ import annotations

import itertools

import numpy as np

from .camera import Camera
from .lens import Perspective
from .model import Scene
from .projection import Matrix, Size, ViewConstants


def screen_bounds(bounds: Matrix, camera: Camera, view: ViewConstants) -> tuple[int, int, int, int] | None:
    """Return the pixels (x, y, width, height from the lower left) that hold the image of a box; None when part of it is
    behind the viewer.

    bounds: (2, 3) least and largest world coordinates. A pixel more on each side, for what rounding does to edges.
    """
    corners = np.array([[*corner, 1.0] for corner in itertools.product(*bounds.T)])
    center = bounds.mean(0)
    to_view = np.linalg.inv(camera.pose)
    clip = (corners - [*center, 0.0]) @ to_view.T + [*(to_view[:3, :3] @ center), 0.0]  # far from the origin, too
    clip = clip @ view.projection.T
    w = clip[:, 3]
    if not (np.isfinite(clip).all() and w.min() > 1e-6 * np.abs(w).max() > 0):
        return None
    size = np.asarray(view.size)
    at = (0.5 + 0.5 * clip[:, :2] / w[:, None]) * size
    low = np.clip(np.floor(at.min(0)) - 1, 0, size)
    high = np.clip(np.ceil(at.max(0)) + 1, 0, size)
    x, y, width, height = (int(v) for v in (*low, *np.maximum(high - low, 0)))
    return x, y, width, height


def unseen(scene: Scene, camera: Camera | None, size: Size) -> str:
    """Return one line when nothing of a scene can be in the image of a camera (None: an automatic one), else nothing."""
    if camera is None:
        return ""
    corners = np.array(list(itertools.product(*scene.bounds.T)))
    toward = (corners - camera.pose[:3, 3]) @ camera.pose[:3, 2]  # the camera looks along -z
    name = scene.name or "the scene"
    if isinstance(camera.lens, Perspective) and toward.min() >= 0:
        return f"nothing is seen: {name} lies behind the camera; look at it by --target, or look_at(eye, target)"
    rect = screen_bounds(scene.bounds, camera, camera.view(size))
    return (
        f"nothing is seen: {name} lies outside the image; look at it by --target, or look_at(eye, target)"
        if rect and 0 in rect[2:]
        else ""
    )
