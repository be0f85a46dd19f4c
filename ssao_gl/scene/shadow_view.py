"""The view of a directional light: a parallel projection that shows all of a scene that a camera can see of it, and no more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .bounds import box_corners
from .camera import Camera
from .lens import CropLens
from .pose import rigid
from .projection import Size

MARGIN = 2.0
"""Texels around what is seen, for filters."""
FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
"""Corners of the faces of a box, as :func:`box_corners` numbers them."""

Points = NDArray[np.float64]


def shadow_camera(to_light: Points, bounds: Points, camera: Camera, size: Size, side: int) -> Camera:
    """Return the camera of a light for a shadow map of ``side`` x ``side`` texels.

    to_light: (3,) unit, world. bounds: (2, 3) of the scene. It shows what ``camera`` sees of the box in an image of ``size``
    pixels, or of the whole image that this is a tile of; and in depth the box as a whole, so that nothing that casts is lost.
    """
    center = bounds.mean(0)
    reach = max(float(np.linalg.norm(bounds[1] - bounds[0])) / 2, 1e-30)
    pose = np.eye(4)
    pose[:3, :3] = _axes(to_light)
    pose[:3, 3] = center + 2 * reach * to_light
    seen = (_seen_corners(bounds, camera, size) - center) @ pose[:3, :2]
    middle, half = (seen.max(0) + seen.min(0)) / 2, (seen.max(0) - seen.min(0)) / 2
    half = np.maximum(half, 1e-3 * reach) * side / (side - 2 * MARGIN)
    matrix = np.eye(4)
    matrix[[0, 1], [0, 1]] = 1 / half
    matrix[:2, 3] = -middle / half
    near, far = 0.9 * reach, 3.1 * reach
    matrix[2, 2:] = -2 / (far - near), -(far + near) / (far - near)
    return Camera.from_matrix(matrix, rigid(pose))


def _axes(to_light: Points) -> Points:
    """Return right, up and backwards (3, 3 by columns) of a view along a light."""
    up = np.eye(3)[int(np.argmin(np.abs(to_light)))]
    right = np.cross(up, to_light)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(to_light, right), to_light])


def _seen_corners(bounds: Points, camera: Camera, size: Size) -> Points:
    """Return the corners (n, 3) of the part of a box that a camera sees; of all of it where it sees nothing."""
    corners = box_corners(*bounds)
    lens, whole = (camera.lens.lens, camera.lens.whole) if isinstance(camera.lens, CropLens) else (camera.lens, size)
    view = Camera(lens, camera.pose).view(whole)
    center = bounds.mean(0)
    to_view = np.linalg.inv(camera.pose)
    to_view[:3, 3] += to_view[:3, :3] @ center  # about the middle of the box: far from the origin, too
    depths = -(to_view[2, :3] @ (corners - center).T + to_view[2, 3])
    near, far = max(view.near, depths.min()), min(view.far, depths.max())
    if not near < far:
        return corners
    rows = view.projection @ to_view
    planes = np.stack([rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1], -to_view[2], to_view[2]])
    planes[4, 3] -= near
    planes[5, 3] += far
    faces = [_clipped((corners - center)[list(face)], planes) for face in FACES]
    ends = _frustum_corners(view.projection, (near, far)) @ np.linalg.inv(to_view).T
    inside = (np.abs(ends[:, :3]) <= (bounds[1] - bounds[0]) / 2 * (1 + 1e-9)).all(1)
    found = np.concatenate([*faces, ends[inside, :3]])
    return found + center if len(found) else corners


def _frustum_corners(projection: Points, depths: tuple[float, float]) -> Points:
    """Return the view-space corners (8, 4) of the image at two depths."""
    inverse = np.linalg.inv(projection[:2, :2])
    out = []
    for z in depths:
        w = projection[3, 3] - projection[3, 2] * z
        for x, y in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
            xy = inverse @ (np.array([x, y]) * w + projection[:2, 2] * z - projection[:2, 3])
            out.append([*xy, -z, 1.0])
    return np.array(out)


def _clipped(polygon: Points, planes: Points) -> Points:
    """Return what half-spaces (n, 4) leave of a convex polygon (m, 3): Sutherland, Hodgman, "Reentrant Polygon Clipping", 1974."""
    for plane in planes:
        heights = polygon @ plane[:3] + plane[3]
        kept = []
        for i, height in enumerate(heights):
            before = heights[i - 1]
            if (height >= 0) != (before >= 0):
                kept.append(polygon[i - 1] + (polygon[i] - polygon[i - 1]) * (before / (before - height)))
            if height >= 0:
                kept.append(polygon[i])
        if not kept:
            return np.zeros((0, 3))
        polygon = np.array(kept)
    return polygon
