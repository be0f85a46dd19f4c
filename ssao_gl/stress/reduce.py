"""Makes a failing input smaller while it still fails: fewer settings, fewer pixels, fewer texels with a surface."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ..scene.camera import Camera
from .shot import Shot

TRIES = 300
"""Pictures drawn at most on the way down."""
Fails = Callable[[Shot], bool]


def smaller(shot: Shot, fails: Fails, tries: int = TRIES) -> Shot:
    """Return the smallest shot over a depth image that is found to fail as ``shot`` does; ``fails`` draws one and tells."""
    left = [tries]

    def still(candidate: Shot) -> bool:
        left[0] -= 1
        return left[0] >= 0 and fails(candidate)

    shot = _first_or_same(shot, _plainer(shot), still)
    while (cropped := _first_or_same(shot, _halves(shot), still)) is not shot:
        shot = cropped
    shot = _blanked(shot, still)
    return _first_or_same(shot, _plainer(shot), still)


def _first_or_same(shot: Shot, candidates: Iterator[Shot], fails: Fails) -> Shot:
    """Return the first candidate that fails, or the shot itself."""
    return next((one for one in candidates if fails(one)), shot)


def _plainer(shot: Shot) -> Iterator[Shot]:
    """With less to it: settings as shipped, no normals, no filter, one depth all over; several at once first."""
    depth = np.asarray(shot.depth, np.float64)
    good = depth[np.isfinite(depth) & (depth > 0)]
    even = np.where(np.isfinite(depth) & (depth > 0), np.median(good) if good.size else 1.0, depth).astype(np.float32)
    yield shot.but(changes={}, normals=None, blur="none", depth=even)
    yield shot.but(changes={}, normals=None, blur="none")
    if shot.blur != "none":
        yield shot.but(changes={}, normals=None)
    yield shot.but(changes={}, blur="none")
    if shot.changes:
        yield shot.but(changes={})


def _halves(shot: Shot) -> Iterator[Shot]:
    assert shot.depth is not None
    h, w = shot.depth.shape
    if w > 1:
        yield crop(shot, slice(0, h), slice(0, (w + 1) // 2))
        yield crop(shot, slice(0, h), slice(w // 2, w))
    if h > 1:
        yield crop(shot, slice(0, (h + 1) // 2), slice(0, w))
        yield crop(shot, slice(h // 2, h), slice(0, w))


def crop(shot: Shot, rows: slice, columns: slice) -> Shot:
    """Return a part of a depth image, under the camera that sees just that part."""
    assert shot.depth is not None
    h, w = shot.depth.shape
    m = shot.camera.view((w, h)).projection.copy()
    left, right = 2 * columns.start / w - 1, 2 * columns.stop / w - 1
    top, bottom = 1 - 2 * rows.start / h, 1 - 2 * rows.stop / h
    m[0] = (2 * m[0] - (left + right) * m[3]) / (right - left)
    m[1] = (2 * m[1] - (top + bottom) * m[3]) / (top - bottom)
    depth = shot.depth[rows, columns]
    normals = None if shot.normals is None else shot.normals[rows, columns]
    return shot.but(camera=Camera.from_matrix(m), depth=depth, normals=normals, size=depth.shape[::-1])


def _blanked(shot: Shot, fails: Fails) -> Shot:
    """With as many texels as will go turned to background, by ever smaller runs of them."""
    assert shot.depth is not None
    background = 0.0 if shot.kind == "eye" else shot.camera.view(shot.depth.shape[::-1]).depth_constants["u_depth_far"]
    depth: NDArray[np.float32] = np.array(shot.depth, np.float32)
    run = depth.size // 2
    while run >= 1:
        for start in range(0, depth.size, run):
            candidate = depth.copy()
            candidate.ravel()[start : start + run] = background
            if not np.array_equal(candidate, depth, equal_nan=True) and fails(shot.but(depth=candidate)):
                depth = candidate
        run //= 2
    return shot.but(depth=depth)
