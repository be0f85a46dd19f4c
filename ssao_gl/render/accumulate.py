"""Stills as the mean of many frames, each with another part of the noise and other places in the pixels."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..pipeline.outputs import aov_names
from ..scene import srgb
from ..scene.camera import Camera
from ..scene.lens import ShiftedLens
from .history import History
from .picture import Picture

MOST = 1024
R2 = 0.7548776662466927, 0.5698402909980532
"""Steps of the R2 sequence (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018)."""

Draw = Callable[[Camera, Sequence[str], History], Picture]
"""Draws the frame of a camera, with the AOVs that are named, as the next one of a sequence."""


def accumulated(draw: Draw, camera: Camera, aovs: str | Sequence[str], count: int) -> Picture:
    """Return the mean of ``count`` frames: of images in linear light, of visibility; of depth, normals and masks the first.

    It converges to what the method says of the view: its noise goes, its own error stays. Raises SettingsError.
    """
    if not 1 <= count <= MOST:
        raise SettingsError(f"accumulate={count}: must be 1 to {MOST} frames")
    names = aov_names(aovs)
    first: Picture | None = None
    sums: dict[str, Any] = {}
    for index in range(count):
        history = History()
        history.frame = index  # its noise; nothing is left by another frame
        picture = draw(jittered(camera, index), names, history)
        first = first or picture
        for name in {"image", "color", "visibility"} & picture.arrays.keys():
            sums[name] = sums.get(name, 0.0) + _summand(name, picture.arrays[name])
    assert first is not None
    arrays = {name: _mean(name, sums[name] / count) if name in sums else array for name, array in first.arrays.items()}
    return Picture(arrays, {**first.report, "accumulated": count})


def jittered(camera: Camera, index: int) -> Camera:
    """Return the camera whose pixels' middles lie elsewhere in the pixels, for each index; for 0 itself."""
    if not index:
        return camera
    shift = tuple((0.5 + index * step) % 1.0 - 0.5 for step in R2)
    return dataclasses.replace(camera, lens=ShiftedLens(camera.lens, (shift[0], shift[1])))


def _summand(name: str, array: NDArray[Any]) -> NDArray[np.float64]:
    """Return what is added up: linear light times alpha, and alpha."""
    if name == "visibility":
        return array.astype(np.float64)
    light = srgb.decode(array[..., :3] / 255)
    if array.shape[2] == 3:
        return light
    alpha = array[..., 3:] / 255
    return np.concatenate([light * alpha, alpha], -1)


def _mean(name: str, mean: NDArray[np.float64]) -> NDArray[Any]:
    """Return an array of the picture from the mean of what was added up."""
    if name == "visibility":
        return mean.astype(np.float32)
    if mean.shape[2] == 4:
        light = np.divide(mean[..., :3], mean[..., 3:], out=np.zeros_like(mean[..., :3]), where=mean[..., 3:] > 0)
        mean = np.concatenate([srgb.encode(light), mean[..., 3:]], -1)
    else:
        mean = srgb.encode(mean)
    return np.round(255 * np.clip(mean, 0, 1)).astype(np.uint8)
