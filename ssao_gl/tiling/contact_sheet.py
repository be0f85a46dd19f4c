"""Many small pictures with their names in one, row by row, so that memory holds one row."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ..pipeline.settings import CALM, Shading
from ..scene.projection import Size
from .thumbnails import Thumbnail

GAP = 8
"""Pixels between tiles, and around all of them."""
LETTERS = (11, 20)
"""Height of names, pixels: at least, at most; between them it goes with the tiles."""
FAULT = (178, 34, 34, 255)
"""sRGB of what could not be drawn."""
MOST_LINES = 12
"""Of the reason in a tile."""


@dataclass(frozen=True, kw_only=True)
class ContactSheet:
    """Where tiles of one size and the names below them lie. columns: None for about as many as rows. background: as of Shading."""

    count: int
    tile: Size
    columns: int | None = None
    background: str = CALM
    names: bool = True

    @property
    def width_in_tiles(self) -> int:
        """Tiles in a row."""
        return max(1, min(self.columns or math.ceil(math.sqrt(self.count)), self.count))

    @property
    def size(self) -> Size:
        """(width, height) of the whole, pixels."""
        rows = -(-self.count // self.width_in_tiles)
        return self.width_in_tiles * (self.tile[0] + GAP) + GAP, rows * (self._step) + GAP

    def bands(self, tiles: Iterable[Thumbnail]) -> Iterator[NDArray[np.uint8]]:
        """Yield the rows of tiles from the top, (h, w, 3) uint8 sRGB, or (h, w, 4) on a ground that can be seen through."""
        rest, last = iter(tiles), -(-self.count // self.width_in_tiles) - 1
        for row in range(last + 1):
            band = Image.new("RGBA", (self.size[0], self._step + (GAP if row == last else 0)), self._ground)
            for column, tile in enumerate(itertools.islice(rest, self.width_in_tiles)):
                self._place(band, GAP + column * (self.tile[0] + GAP), tile)
            pixels = np.array(band)
            yield pixels if self._ground[3] < 255 else pixels[..., :3]

    @cached_property
    def _ground(self) -> tuple[int, int, int, int]:
        r, g, b, a = (round(255 * part) for part in Shading(background=self.background).background_rgba)
        return r, g, b, a

    @cached_property
    def _font(self) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
        low, high = LETTERS
        return ImageFont.load_default(size=min(max(self.tile[0] // 18, low), high))

    @cached_property
    def _line(self) -> int:
        """Height of a line of text, pixels."""
        return math.ceil(1.3 * getattr(self._font, "size", LETTERS[0]))

    @property
    def _step(self) -> int:
        return GAP + self.tile[1] + (self._line if self.names else 0)

    @property
    def _ink(self) -> tuple[int, int, int, int]:
        r, g, b, alpha = self._ground
        if alpha < 128:
            return 128, 128, 128, 255  # on whatever lies behind
        return (0, 0, 0, 255) if 0.3 * r + 0.59 * g + 0.11 * b > 110 else (255, 255, 255, 255)

    def _place(self, band: Image.Image, x: int, tile: Thumbnail) -> None:
        (w, h), draw = self.tile, ImageDraw.Draw(band)
        if tile.image is None:
            draw.rectangle((x, GAP, x + w - 1, GAP + h - 1), outline=FAULT, width=2)
            lines = list(self._wrapped(tile.fault, w - 16))[: min(MOST_LINES, max((h - 8) // self._line, 1))]
            draw.multiline_text((x + 8, GAP + 4), "\n".join(lines), FAULT, self._font, spacing=2)
        else:
            band.paste(Image.fromarray(tile.image), (x, GAP))
        if self.names:
            text = self._cut(_shown(tile.name), w)
            left = x + (w - self._font.getlength(text)) / 2
            draw.text((left, GAP + h + 1), text, self._ink, self._font)

    def _cut(self, text: str, width: int) -> str:
        """Return a text with an ellipsis in its middle, where it is too wide."""
        kept = len(text)
        shown = text
        while kept > 1 and self._font.getlength(shown) > width:
            kept -= 1
            shown = f"{text[: (kept + 1) // 2]}…{text[len(text) - kept // 2 :]}"
        return shown

    def _wrapped(self, text: str, width: int) -> Iterator[str]:
        """Yield lines no wider than ``width`` pixels; words that are too wide are cut."""
        line = ""
        for word in _shown(text).split():
            longer = f"{line} {word}".strip()
            if line and self._font.getlength(longer) > width:
                yield line
                longer = word
            line = self._cut(longer, width)
        if line:
            yield line


def _shown(text: str) -> str:
    """Return a text whose characters can all be drawn on one line."""
    return "".join(c if c.isprintable() else "?" for c in text)
