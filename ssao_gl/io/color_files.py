"""Reading colour as occlusion dims it: uint8 sRGB."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, warn_of_input
from .images import load_image, to_bytes


def load_color(path: Path | str) -> NDArray[np.uint8]:
    """Read a picture as uint8 sRGB, (h, w, 3) or (h, w, 4); grey is repeated, 16 bits become 8. Raises FormatError."""
    array = load_image(path)
    if array.dtype == np.uint16:
        warn_of_input(f"{path}: its 16 bits a channel become 8")
        array = to_bytes(array / 65535)
    if array.ndim == 2:
        array = array[..., None]
    if array.dtype != np.uint8 or array.shape[2] not in (1, 3, 4):
        raise FormatError(
            f"{path}: holds {array.dtype} of shape {array.shape}; expected uint8 sRGB colour, (h, w, 3) or (h, w, 4)"
        )
    return np.repeat(array, 3, -1) if array.shape[2] == 1 else array
