"""Pictures of textures, unpacked with care: only the usual formats, and only as many texels as their files can mean."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..io.images import PICTURES

FREE, RATIO = 1 << 26, 16
"""Texels that the pictures of a scene may have (8192 x 8192), or 16 a byte of their files if that is more."""


class Texels:
    """Turns pictures to arrays, and counts."""

    def __init__(self) -> None:
        self._held = self._taken = 0

    def unpack(self, content: bytes) -> NDArray[np.uint8]:
        """Texels (h, w, 3 or 4) of a file. Raises whatever Pillow does, and ValueError."""
        # Not by Image.open's own choice: some formats start programs.
        return self.array(Image.open(io.BytesIO(content), formats=PICTURES), len(content))

    def array(self, image: Any, size: int) -> NDArray[np.uint8]:
        """Likewise of a picture of Pillow that was opened from a file of ``size`` bytes. Raises ValueError."""
        if image.format not in (None, *PICTURES):
            raise ValueError(f"{image.format} pictures are not read")
        self._held += size
        self._taken += image.width * image.height
        if self._taken > max(FREE, RATIO * self._held):
            self._taken -= image.width * image.height
            raise ValueError(f"its {image.width}x{image.height} texels are far more than its file can mean")
        alpha = "A" in image.mode or "transparency" in image.info
        if image.mode in ("I;16", "I;16B", "I;16L", "I"):  # Pillow would cut what is above 255
            grey = (np.asarray(image).astype(np.int64) >> 8).clip(0, 255).astype(np.uint8)
            return np.repeat(grey[..., None], 3, 2)
        return np.asarray(image.convert("RGBA" if alpha else "RGB"))


def picture_size(path: Path) -> tuple[int, int] | None:
    """Return (width, height) as a picture file's header says them; None when there is no such picture."""
    try:
        with Image.open(path, formats=PICTURES) as image:
            return image.size
    except (OSError, ValueError, Image.DecompressionBombError):
        return None


def file_size(image: Any) -> int:
    """Bytes of the file that a picture was opened from; of one that was made in memory, of its texels."""
    stream: Any = getattr(image, "fp", None)
    try:
        at = stream.tell()
        size = stream.seek(0, 2)
        stream.seek(at)
        return int(size)
    except (AttributeError, OSError, ValueError):
        return int(image.width * image.height)
