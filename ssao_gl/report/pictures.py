"""Small pictures for the page: truth, methods, and maps of their error on one colour scale."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import images
from ..files import make_folder
from .sweep import folder_name, images_of

F64 = NDArray[np.float64]

WIDTH = 480
"""Largest width of a picture, pixels: larger ones are averaged down."""

SPAN = 0.4
"""Error at the ends of the colour scale."""

SCALE = ((5, 48, 97), (67, 147, 195), (247, 247, 247), (214, 96, 77), (103, 0, 31))
"""sRGB at errors of -SPAN (too dark), ..., 0, ..., +SPAN (too bright), evenly spaced: ColorBrewer's RdBu, reversed."""

NOWHERE = (128, 128, 128)
"""Where there is no surface."""


def error_map(visibility: NDArray[Any], truth: NDArray[Any], seen: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """``visibility - truth`` as colours (h, w, 3)."""
    return colored(np.where(seen, visibility.astype(np.float64) - truth, np.nan))


def colored(error: F64) -> NDArray[np.uint8]:
    """Errors of any shape to colours, with one axis more; nan to grey."""
    stops = np.linspace(-SPAN, SPAN, len(SCALE))
    channels = [np.interp(np.nan_to_num(error), stops, [color[i] for color in SCALE]) for i in range(3)]
    out = np.where(np.isnan(error)[..., None], NOWHERE, np.round(np.stack(channels, -1)))
    return np.asarray(out, np.uint8)


def reduced(image: NDArray[Any], width: int = WIDTH) -> NDArray[np.float64]:
    """An image (h, w) or (h, w, c) averaged down over whole blocks until it is at most ``width`` wide."""
    block = -(-image.shape[1] // width)
    h, w = (side // block * block for side in image.shape[:2])
    if not h or not w:
        return image.astype(np.float64)
    parts = image[:h, :w].reshape(h // block, block, w // block, block, *image.shape[2:])
    return np.asarray(parts.mean((1, 3)), np.float64)


def save_truth(folder: Path, view: str, truth: NDArray[Any]) -> str:
    """Write the truth of a view; returns its name in the folder of pictures."""
    return _save(folder, f"{folder_name(view)}-truth.png", images.to_bytes(reduced(truth)))


def save_method(
    folder: Path, view: str, label: str, visibility: NDArray[Any], truth: NDArray[Any], seen: NDArray[np.bool_]
) -> tuple[str, str]:
    """Write a method's visibility and its error map; returns their names."""
    stem = f"{folder_name(view)}-{folder_name(label)}"
    errors = np.round(reduced(error_map(visibility, truth, seen))).astype(np.uint8)
    return (
        _save(folder, f"{stem}.png", images.to_bytes(reduced(visibility))),
        _save(folder, f"{stem}-error.png", errors),
    )


def _save(folder: Path, name: str, image: NDArray[Any]) -> str:
    make_folder(images_of(folder))
    images.save(images_of(folder) / name, image)
    return name
