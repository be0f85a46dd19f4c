"""Cameras along a path: through key cameras, smoothly."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from ..errors import SceneError
from ..scene.camera import Camera
from ..scene.lens import Lens, Perspective
from ..scene.projection import Size

A_SEGMENT = 24
"""Views from one key camera to the next, where no number is asked for."""


def along(keys: Sequence[Camera], count: int | None, size: Size) -> list[Camera]:
    """Return ``count`` cameras from the first key camera to the last, called by their numbers.

    Positions lie on a monotone cubic through the keys (Fritsch, Carlson 1980), which never overshoots into a wall; turns are the
    shortest (spherical linear interpolation). Times of keys go by the square root of their distance (centripetal), which keeps
    sharp bends from looping. Vertical angles are interpolated where all lenses are symmetric, else the first key's lens
    stays. Raises SceneError for less than two keys.
    """
    if len(keys) < 2:
        raise SceneError("a path needs at least two cameras to go through")
    from scipy.interpolate import PchipInterpolator
    from scipy.spatial.transform import Rotation, Slerp

    eyes = np.array([key.pose[:3, 3] for key in keys])
    gaps = np.sqrt(np.linalg.norm(np.diff(eyes, axis=0), axis=1))
    times = np.concatenate([[0.0], np.cumsum(gaps + max(1e-3 * gaps.sum(), 1e-12))])
    number = count or A_SEGMENT * (len(keys) - 1) + 1
    at = np.linspace(0, times[-1], number)
    places = PchipInterpolator(times, eyes)(at)
    turns = Slerp(times, Rotation.from_matrix(np.array([key.pose[:3, :3] for key in keys])))(at).as_matrix()
    poses = np.tile(np.eye(4), (number, 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = turns, places
    width = max(4, len(str(number - 1)))
    return [
        dataclasses.replace(keys[0], pose=pose, lens=lens, name=f"path_{index:0{width}d}")
        for index, (pose, lens) in enumerate(zip(poses, _lenses(keys, times, at), strict=True))
    ]


def _lenses(keys: Sequence[Camera], times: np.ndarray, at: np.ndarray) -> list[Lens]:
    symmetric = [key.lens for key in keys if isinstance(key.lens, Perspective)]
    if len(symmetric) < len(keys):
        return [keys[0].lens] * len(at)
    angles = np.interp(at, times, [lens.yfov for lens in symmetric])
    return [dataclasses.replace(symmetric[0], yfov=float(angle)) for angle in angles]
