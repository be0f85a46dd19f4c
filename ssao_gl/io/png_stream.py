"""PNG files written row by row, in memory that does not grow with the picture (Pillow wants it whole)."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Mapping
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL.PngImagePlugin import putchunk

from ..errors import FormatError
from ..scene.projection import Size
from .images import png_texts

LEVEL = 4
"""Of compression, as for pictures that are written whole."""

GREY, RGB, RGBA = 0, 2, 6
SUB, UP = 1, 2


def write_png_rows(file: BinaryIO, size: Size, bands: Iterable[NDArray[Any]], texts: Mapping[str, str] | None = None) -> None:
    """Write a picture of ``size`` (width, height) that comes in ``bands`` of whole rows from the top.

    Bands: (rows, width) or (rows, width, 3 or 4), uint8 or uint16. Raises FormatError for others, or when they are not
    ``height`` rows in all.
    """
    compressor = zlib.compressobj(LEVEL)
    above: NDArray[np.uint8] | None = None
    rows = 0
    for band in bands:
        _check(band, size[0])
        samples = band.shape[2] if band.ndim == 3 else 1
        lines = np.ascontiguousarray(band, band.dtype.newbyteorder(">")).reshape(len(band), -1).view(np.uint8)
        if above is None:
            _begin(file, size, band.dtype.itemsize, samples, texts or {})
            above = np.zeros_like(lines[0])
        _put(file, compressor.compress(_filtered(lines, above, samples * band.dtype.itemsize)))
        above = lines[-1]
        rows += len(band)
    if rows != size[1]:
        raise FormatError(f"a PNG of {size[0]}x{size[1]} got {rows} rows")
    _put(file, compressor.flush())
    putchunk(file, b"IEND")


def _check(band: NDArray[Any], width: int) -> None:
    deep = band.dtype == np.uint16 and band.ndim == 2
    shape = band.shape[1:] in ((width,), (width, 3), (width, 4))
    if not shape or not len(band) or not (deep or band.dtype == np.uint8):
        raise FormatError(
            f"a band of a PNG {width} pixels wide is {band.dtype} of shape {band.shape}; expected uint8 or uint16"
        )


def _begin(file: BinaryIO, size: Size, depth: int, samples: int, texts: Mapping[str, str]) -> None:
    file.write(b"\x89PNG\r\n\x1a\n")
    kind = {1: GREY, 3: RGB, 4: RGBA}[samples]
    putchunk(file, b"IHDR", struct.pack(">IIBBBBB", *size, 8 * depth, kind, 0, 0, 0))
    for name, content, *_ in png_texts(texts).chunks:
        putchunk(file, name, content)


def _put(file: BinaryIO, data: bytes) -> None:
    if data:
        putchunk(file, b"IDAT", data)


def _filtered(lines: NDArray[np.uint8], above: NDArray[np.uint8], pixel: int) -> bytes:
    """Rows (n, bytes) as PNG stores them, each by the filter (none, from the left, from above) of the smallest sum.

    ``above`` is the row before the first, ``pixel`` the bytes of one pixel.
    """
    left = lines.copy()
    left[:, pixel:] -= lines[:, :-pixel]
    up = lines.copy()
    up[0] -= above
    up[1:] -= lines[:-1]
    choices = (lines, left, up)
    # Differences count as signed: 255 is -1.
    cost = np.stack([np.minimum(choice, -choice).sum(1, np.int64) for choice in choices])
    best = cost.argmin(0)
    out = np.empty((len(lines), 1 + lines.shape[1]), np.uint8)
    out[:, 0], out[:, 1:] = best, lines
    out[best == SUB, 1:], out[best == UP, 1:] = left[best == SUB], up[best == UP]
    return out.tobytes()
