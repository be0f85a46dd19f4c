"""Small pictures for the page: truth, methods, and maps of their error on one colour scale."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..io import images
from ..io.atomic import atomic_write, make_folder
from ..metrics.zones import Zones
from .sweep import folder_name, images_of

WIDTH = 480
"""Largest width of a picture, pixels: larger ones are averaged down."""

SPAN = 0.4
"""Error at the ends of the colour scale."""

SCALE = ((5, 48, 97), (67, 147, 195), (247, 247, 247), (214, 96, 77), (103, 0, 31))
"""sRGB at errors of -SPAN (too dark), ..., 0, ..., +SPAN (too bright), evenly spaced: ColorBrewer's RdBu, reversed."""

LEVELS = 65
"""Steps of the scale."""

NOWHERE = (128, 128, 128)
"""Where there is no surface."""


ZONE_COLORS = {"edge": (200, 48, 48), "crease": (240, 165, 40), "flat": (225, 228, 231)}
"""sRGB of the zones in their map."""


def indices(error: ArrayLike) -> NDArray[np.uint8]:
    """Errors of any shape to places in the palette."""
    level = np.round((np.asarray(error, np.float64) / SPAN + 1) / 2 * (LEVELS - 1))
    return np.where(np.isnan(level), LEVELS, np.clip(np.nan_to_num(level), 0, LEVELS - 1)).astype(np.uint8)


def palette() -> NDArray[np.uint8]:
    """(LEVELS + 1, 3): the scale in even steps, and the colour of nowhere."""
    stops, at = np.linspace(0, 1, len(SCALE)), np.linspace(0, 1, LEVELS)
    channels = [np.interp(at, stops, [color[i] for color in SCALE]) for i in range(3)]
    return np.round(np.concatenate([np.stack(channels, -1), [NOWHERE]])).astype(np.uint8)


def reduced(image: NDArray[Any], width: int = WIDTH) -> NDArray[np.float64]:
    """Return an image (h, w) or (h, w, c) averaged down over whole blocks until it is at most ``width`` wide."""
    block = -(-image.shape[1] // width)
    h, w = (side // block * block for side in image.shape[:2])
    if not h or not w:
        return image.astype(np.float64)
    parts = image[:h, :w].reshape(h // block, block, w // block, block, *image.shape[2:])
    return np.asarray(parts.mean((1, 3)), np.float64)


def zone_indices(zones: Zones, width: int = WIDTH) -> NDArray[np.uint8]:
    """Places of zones in the palette of :data:`ZONE_COLORS`, then nowhere; of whole blocks the first pixel."""
    block = -(-zones.flat.shape[1] // width)
    names = list(ZONE_COLORS)
    places = np.select([getattr(zones, name) for name in names], range(len(names)), len(names)).astype(np.uint8)
    return places[::block, ::block]


def save_truth(folder: Path, view: str, truth: NDArray[Any], zones: Zones) -> None:
    """Write the truth of a view, and the map of its zones."""
    _save(folder, f"{folder_name(view)}-truth.png", images.to_bytes(reduced(truth)))
    colors = np.array([*ZONE_COLORS.values(), NOWHERE], np.uint8)
    _save(folder, f"{folder_name(view)}-zones.png", zone_indices(zones), colors)


def save_method(
    folder: Path, view: str, label: str, visibility: NDArray[Any], truth: NDArray[Any], seen: NDArray[np.bool_]
) -> None:
    """Write a method's visibility and, where something is seen, the map of its error."""
    stem = f"{folder_name(view)}-{folder_name(label)}"
    _save(folder, f"{stem}.png", images.to_bytes(reduced(visibility)))
    share = reduced(seen.astype(np.float64))
    total = reduced(np.where(seen, visibility.astype(np.float64) - truth, 0.0))
    error = np.divide(total, share, out=np.full_like(total, np.nan), where=share > 0)
    _save(folder, f"{stem}-error.png", indices(error), palette())


def _save(folder: Path, name: str, image: NDArray[np.uint8], colors: NDArray[np.uint8] | None = None) -> None:
    """Write a PNG, grey or by a palette, which makes maps a quarter as large."""
    from PIL import Image

    make_folder(images_of(folder))
    picture = Image.fromarray(image)
    if colors is not None:
        picture.putpalette(colors.tobytes())
    with atomic_write(images_of(folder) / name) as temporary:
        picture.save(temporary, format="PNG", optimize=True)
