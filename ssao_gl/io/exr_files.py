"""Reading the channels of EXR files, which renderers name after layers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .streams import silenced


def exr_channels(path: Path, most_pixels: int) -> dict[str, NDArray[Any]]:
    """Return the full-size channels (h, w) of all parts by name, in the display window; part names tell doubles apart.

    Raises FormatError for pictures of more pixels, before memory is taken for them, and whatever OpenEXR raises.
    """
    try:
        import OpenEXR
    except ImportError:
        raise FormatError("EXR needs the package OpenEXR: pip install 'ssao_gl[exr]'") from None
    with silenced():
        with OpenEXR.File(str(path), separate_channels=True, header_only=True) as file:
            for part in file.parts:
                for window in ("dataWindow", "displayWindow"):
                    low, high = (np.asarray(corner).astype(object) for corner in part.header[window])
                    if not 0 < int(np.prod(high - low + 1)) <= most_pixels:
                        raise FormatError(f"{path}: announces a picture from {low} to {high}; too large")
        with OpenEXR.File(str(path), separate_channels=True) as file:
            return _joined(file.parts)


def _joined(parts: Any) -> dict[str, NDArray[Any]]:
    found: dict[str, NDArray[Any]] = {}
    for index, part in enumerate(parts):
        (x0, y0), (x1, y1) = part.header["displayWindow"]
        (left, top), _ = part.header["dataWindow"]
        for name, channel in part.channels.items():
            if channel.pixels is None or (channel.xSampling, channel.ySampling) != (1, 1):
                continue
            pixels = np.asarray(channel.pixels)
            shown = pixels
            if (left, top) != (x0, y0) or pixels.shape != (y1 - y0 + 1, x1 - x0 + 1):
                shown = np.zeros((y1 - y0 + 1, x1 - x0 + 1), pixels.dtype)
                rows, columns = np.arange(pixels.shape[0]) + top - y0, np.arange(pixels.shape[1]) + left - x0
                r, c = (rows >= 0) & (rows < shown.shape[0]), (columns >= 0) & (columns < shown.shape[1])
                shown[np.ix_(rows[r], columns[c])] = pixels[np.ix_(r, c)]
            found[name if name not in found else f"{part.header.get('name', index)}.{name}"] = shown
    return found
