"""Reading pictures of light from all around: equirectangular, linear, in EXR, Radiance HDR or any picture of 8 bits."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from ..scene.srgb import decode
from .atomic import why_unreadable
from .color_files import load_color
from .exr_files import exr_channels

MOST_PIXELS = 1 << 26


def load_panorama(path: Path) -> NDArray[np.float32]:
    """Read linear light (h, w, 3), row 0 on top; sRGB of 8 bits is decoded. Raises FormatError."""
    if reason := why_unreadable(path):
        raise FormatError(f"{path}: {reason}; expected an equirectangular picture: EXR, HDR, PNG or JPEG")
    suffix = path.suffix.lower()
    if suffix == ".exr":
        light = _exr(path)
    elif suffix == ".hdr":
        light = _radiance(path, path.read_bytes())
    else:
        light = decode(load_color(path)[..., :3] / 255).astype(np.float32)
    if not np.isfinite(light).all() or light.min() < 0:
        raise FormatError(f"{path}: holds light that is negative or no number; expected finite linear light")
    return light


def _exr(path: Path) -> NDArray[np.float32]:
    try:
        channels = exr_channels(path, MOST_PIXELS)
    except FormatError:
        raise
    except Exception as error:  # OpenEXR raises many
        raise FormatError(f"{path}: cannot be read as EXR ({str(error)[:100]})") from None
    if not {"R", "G", "B"} <= set(channels):
        raise FormatError(f"{path}: has the channels {', '.join(channels) or 'none'}; expected R, G and B")
    return np.stack([channels[name].astype(np.float32) for name in "RGB"], -1)


def _radiance(path: Path, data: bytes) -> NDArray[np.float32]:
    """Decode a Radiance picture: three mantissas with one exponent (Ward, "Real Pixels", Graphics Gems II, 1991)."""
    head = re.match(rb"#\?(?:RADIANCE|RGBE)\n(?:[^\n]*\n)*?\n-Y (\d{1,6}) \+X (\d{1,6})\n", data)
    if head is None:
        raise FormatError(f"{path}: is no Radiance picture with rows from the top (-Y height +X width)")
    h, w = int(head[1]), int(head[2])
    if not 0 < h * w <= MOST_PIXELS:
        raise FormatError(f"{path}: announces {w}x{h} pixels; too large")
    packed = np.frombuffer(data, np.uint8, offset=head.end())
    texels = np.zeros((h, w, 4), np.uint8)
    at = 0
    try:
        for row in range(h):
            if w < 8 or w > 0x7FFF or tuple(packed[at : at + 3]) != (2, 2, w >> 8):
                texels[row] = packed[at : at + 4 * w].reshape(w, 4)
                at += 4 * w
            else:
                at = _runs(packed, at + 4, texels[row])
    except (IndexError, ValueError):
        raise FormatError(f"{path}: ends, or breaks off, in row {row} of {h}") from None
    scale = np.where(texels[..., 3:] > 0, np.ldexp(np.float32(1.0), texels[..., 3:].astype(np.int32) - 136), np.float32(0))
    return np.asarray(texels[..., :3] * scale, np.float32)


def _runs(packed: NDArray[np.uint8], at: int, row: NDArray[np.uint8]) -> int:
    """Unpack a row (w, 4) of runs, a channel after another, and return where the next one begins. Raises IndexError, ValueError."""
    for channel in range(4):
        x = 0
        while x < len(row):
            count = int(packed[at])
            run = count > 128
            length = count - 128 if run else count
            if length == 0 or x + length > len(row):
                raise ValueError
            row[x : x + length, channel] = packed[at + 1] if run else packed[at + 1 : at + 1 + length]
            at += 2 if run else 1 + length
            x += length
    return at
