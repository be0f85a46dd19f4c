"""Reading and writing pictures and arrays by suffix, and the one place where rows are flipped.

Arrays are (h, w) or (h, w, c) with row 0 on top; OpenGL's have row 0 at the bottom.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, encodable
from .atomic import atomic_write, why_unreadable
from .exr_files import exr_channels
from .streams import output_suffix

if TYPE_CHECKING:
    from PIL.PngImagePlugin import PngInfo

SUFFIXES = (".png", ".npy", ".exr")
MAX_PIXELS = 1 << 30
"""Larger pictures are refused on reading: a few bytes of a hostile file can claim any size."""

PICTURES = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF", "PPM", "TGA")
"""Pillow's formats that are read. Some of the others start programs (Ghostscript for EPS)."""


def flipped(array: NDArray[Any]) -> NDArray[Any]:
    """Rows in the other order, contiguous: from OpenGL's to ours and back."""
    return np.ascontiguousarray(array[::-1])


def to_bytes(values: NDArray[Any], bits: int = 8) -> NDArray[Any]:
    """Values in 0..1 to unsigned integers of 8 or 16 bits, rounded; NaN gives 0."""
    top = 255 if bits == 8 else 65535
    rounded: NDArray[Any] = np.round(np.clip(np.nan_to_num(values), 0, 1) * top)
    return rounded.astype(np.uint8 if bits == 8 else np.uint16)


def save_image(path: Path | str, array: NDArray[Any], *, texts: Mapping[str, str] | None = None) -> None:
    """Write an array by suffix: PNG (uint8 or uint16, grey, RGB or RGBA), NPY, EXR (float32). Raises FormatError."""
    path = Path(path)
    suffix = output_suffix(path)
    if suffix not in SUFFIXES:
        raise FormatError(f"cannot write {path}: suffix '{suffix}'; use one of {', '.join(SUFFIXES)}, or a folder")
    with atomic_write(path) as temporary:
        if suffix == ".npy":
            with temporary.open("wb") as file:
                np.save(file, array, allow_pickle=False)
        elif suffix == ".exr":
            _save_exr(temporary, array, texts or {})
        else:
            _save_png(temporary, array, texts or {})


def _save_png(path: Path, array: NDArray[Any], texts: Mapping[str, str]) -> None:
    from PIL import Image

    if array.dtype == np.uint16 and array.ndim == 3:
        raise FormatError(f"16-bit PNG is for grey pictures (depth, visibility); this one has {array.shape[2]} channels")
    if array.dtype not in (np.uint8, np.uint16):
        array = to_bytes(array)
    Image.fromarray(array).save(path, format="PNG", pnginfo=png_texts(texts), compress_level=4)


def png_texts(texts: Mapping[str, str]) -> PngInfo:
    """Return the text chunks of a PNG file."""
    from PIL.PngImagePlugin import PngInfo

    info = PngInfo()
    for key, text in texts.items():
        info.add_text(key, encodable(text))
    return info


def png_bytes(array: NDArray[np.uint8], *, shrink: int = 1) -> bytes:
    """Return a PNG file in memory. ``shrink``: every so many pixels along each side become one, by their mean."""
    from io import BytesIO

    from PIL import Image

    out = BytesIO()
    Image.fromarray(array).reduce(shrink).save(out, format="PNG")
    return out.getvalue()


def _save_exr(path: Path, array: NDArray[Any], texts: Mapping[str, str]) -> None:
    try:
        import OpenEXR
    except ImportError:
        raise FormatError("EXR needs the package OpenEXR: pip install 'ssao_gl[exr]'") from None
    if array.dtype == np.uint8:
        array = array.astype(np.float32) / 255
    array = np.ascontiguousarray(array, np.float32)
    name = "Y" if array.ndim == 2 else {3: "RGB", 4: "RGBA"}[array.shape[2]]
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **dict(texts)}
    with OpenEXR.File(header, {name: array}) as file:
        try:
            file.write(str(path))
        except RuntimeError as error:  # all that the library says of a full disk
            raise OSError("the EXR encoder failed") from error


def load_image(path: Path | str, most_pixels: int = MAX_PIXELS) -> NDArray[Any]:
    """Read a picture or array: PNG and what else Pillow reads, upright (uint8 or uint16, more where the file has it), NPY,
    EXR (float32). Raises FormatError; for what has more pixels, before memory is taken for them."""
    path = Path(path)
    if reason := why_unreadable(path):
        raise FormatError(f"{path}: {reason}; expected a picture or array")
    suffix = path.suffix.lower()
    try:
        if suffix == ".npy":
            array = _load_npy(path, most_pixels)
        elif suffix == ".exr":
            array = _load_exr(path, most_pixels)
        else:
            array = _load_picture(path, most_pixels)
    except FormatError:
        raise
    except Exception as error:
        raise FormatError(f"{path}: not a readable picture or array ({_brief(error)})") from None
    if array.ndim not in (2, 3) or 0 in array.shape or array.dtype.kind not in "fiub":
        raise FormatError(f"{path}: holds {array.dtype} of shape {array.shape}; expected numbers, (h, w) or (h, w, channels)")
    return array


def _load_npy(path: Path, most_pixels: int) -> NDArray[Any]:
    # Mapped, so that a header which claims more than the file holds fails before memory is taken.
    mapped = np.load(path, mmap_mode="r", allow_pickle=False)
    if not isinstance(mapped, np.ndarray):
        raise FormatError(f"{path}: is an archive of arrays (NPZ); expected one array (NPY)")
    if mapped.size > 4 * most_pixels:
        raise FormatError(f"{path}: an array of shape {mapped.shape} is too large; expected at most {most_pixels} pixels")
    return np.array(mapped)


def _load_picture(path: Path, most_pixels: int) -> NDArray[Any]:
    from PIL import Image, ImageOps

    with warnings.catch_warnings(), _pillow_limit(most_pixels), Image.open(path, formats=PICTURES) as image:
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        if image.width * image.height > most_pixels:
            raise FormatError(f"{path}: announces {image.width}x{image.height} pixels; expected at most {most_pixels}")
        upright = ImageOps.exif_transpose(image)  # as viewers turn photographs
        if upright.mode in ("I", "I;16", "I;16B", "I;16L"):
            levels = np.asarray(upright)
            return levels.astype(np.uint16) if levels.min() >= 0 and levels.max() < 1 << 16 else levels
        if upright.mode not in ("L", "RGB", "RGBA", "F"):
            upright = upright.convert("RGBA" if "A" in upright.mode or "transparency" in upright.info else "RGB")
        return np.asarray(upright)


@contextmanager
def _pillow_limit(most_pixels: int) -> Iterator[None]:
    """Pillow's own limit is a global of that package, which belongs to the caller."""
    from PIL import Image

    before, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, most_pixels
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = before


def _load_exr(path: Path, most_pixels: int) -> NDArray[Any]:
    channels = exr_channels(path, most_pixels)
    if {"R", "G", "B"} <= channels.keys():
        return np.stack([channels[name] for name in "RGBA" if name in channels], -1).astype(np.float32)
    name = next((name for name in ("Y", "Z", "V") if name in channels), next(iter(channels)))
    return channels[name].astype(np.float32)


def _brief(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:160]}" if text else type(error).__name__
