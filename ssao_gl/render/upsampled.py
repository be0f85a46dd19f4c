"""Pictures over depth that is smaller than its colour: drawn at the size of the depth, brought to the size of the colour."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..io.srgb import dimmed
from ..pipeline.settings import Settings
from ..scene.joint_upsampling import JointUpsampling, check_upsampled


def needs_upsampling(color: NDArray[Any] | None, depth: NDArray[Any], settings: Settings | None) -> bool:
    """Return whether colour is larger than depth.

    Raises FormatError for sizes that do not go together, SettingsError where halos, tint or power are asked for.
    """
    if color is None or np.ndim(color) != 3 or np.ndim(depth) != 2 or color.dtype != np.uint8 or color.shape[2] not in (3, 4):
        return False  # which the check of the arrays refuses
    if color.shape[:2] == depth.shape or color.shape[0] < depth.shape[0] or color.shape[1] < depth.shape[1]:
        return False
    check_upsampled(depth.shape[::-1], color.shape[1::-1])
    if settings is not None and settings.shading.halo:
        raise SettingsError("shading.halo: colour is larger than depth; halos need both of one size")
    if settings is not None and settings.shading.toned:
        raise SettingsError("shading.tint, shading.power: colour is larger than depth; these need both of one size")
    return True


def upsampled(
    arrays: Mapping[str, NDArray[Any]], drawn: Mapping[str, NDArray[Any]], color: NDArray[np.uint8], strength: float
) -> dict[str, NDArray[Any]]:
    """Return the arrays of a picture at the size of ``color``, and the image: colour dimmed by ``strength`` of the occlusion.

    drawn: visibility and depth of that picture.
    """
    to = JointUpsampling(drawn["depth"], color)
    visibility = np.where(to.depth > 0, to.mean(drawn["visibility"]), np.float32(1)).astype(np.float32)
    known = {"visibility": visibility, "depth": to.depth}
    larger = {name: known[name] if name in known else to.directions(array) for name, array in arrays.items()}
    return {**larger, "image": dimmed(color, visibility, strength)}
