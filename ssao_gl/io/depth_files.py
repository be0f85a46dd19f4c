"""Reading depth images: NPY (also .npy.gz), NPZ, PNG, PGM, TIFF, PFM, and EXR by the names that renderers give to channels."""

from __future__ import annotations

import gzip
import re
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError, SettingsError, near_miss, one_line, warn_of_input
from ..scene.depth_image import DepthImage
from .atomic import why_unreadable
from .exr_files import exr_channels
from .images import load_image

Array = NDArray[Any]
MAX_DEPTH_PIXELS = 1 << 28
"""Larger files are refused before memory is taken: settling depth takes some ten times theirs."""


class DepthForm(TypedDict, total=False):
    """What may be said of a depth image that is an array or a file; see :class:`~ssao_gl.DepthImage` and :func:`load_depth`."""

    depth_kind: str
    depth_scale: float | None
    depth_channel: str | None
    depth_background: float | None
    depth_mask: ArrayLike | None
    depth_noise: float


def as_depth_image(source: ArrayLike | DepthImage | Path, **form: Unpack[DepthForm]) -> DepthImage:
    """Return a depth image from an array, a file, or itself. Raises FormatError, SettingsError."""
    said = {key.removeprefix("depth_"): value for key, value in form.items()}
    if unknown := said.keys() - {"kind", "scale", "channel", "background", "mask", "noise"}:
        raise TypeError(f"unexpected keyword argument '{sorted(unknown)[0]}'")
    if isinstance(source, DepthImage):
        if said:
            raise SettingsError(f"depth is a DepthImage already; say {', '.join(sorted(said))} there")
        return source
    channel = said.pop("channel", None)
    if isinstance(source, str | Path):
        source = load_depth(source, channel)  # type: ignore[arg-type]
    elif channel is not None:
        raise SettingsError("depth channel: is for EXR and NPZ files; give the array itself")
    return DepthImage(source, **said)  # type: ignore[arg-type]


def load_depth(path: Path | str, member: str | None = None) -> Array:
    """Read depth as stored: (h, w) or (h, w, 1) numbers, row 0 on top.

    ``member``: the channel of an EXR file or the array of an NPZ file; else channel Z or V, alone or behind a layer's name,
    colour whose channels are equal, or the only one there is. Raises FormatError.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    packed = path.name.lower().endswith(".npy.gz")
    if suffix not in (".exr", ".npz") and member is not None:
        raise FormatError(f"{path}: has no channel '{member}' to choose; channels are named in EXR and NPZ files")
    if suffix not in (".exr", ".npz") and not packed:
        return _as_one(_true_levels(path, load_image(path, MAX_DEPTH_PIXELS)), path)
    if reason := why_unreadable(path):
        raise FormatError(f"{path}: {reason}; expected a depth image")
    try:
        if packed:
            return _from_gzip(path)
        return _from_exr(path, member) if suffix == ".exr" else _from_npz(path, member)
    except FormatError:
        raise
    except Exception as error:
        raise FormatError(f"{path}: not a readable depth image ({one_line(error, 160)})") from None


def _as_one(array: Array, path: Path) -> Array:
    """Return colour whose channels are equal as one channel. Raises FormatError when they are not."""
    if array.ndim == 3 and array.shape[2] > 1 and array.shape[0] > 1:
        if array.shape[2] > 2 and all(np.array_equal(array[..., 0], array[..., i], equal_nan=True) for i in (1, 2)):
            return np.ascontiguousarray(array[..., 0])
        raise FormatError(f"{path}: holds colour, {array.dtype} of shape {array.shape}; depth has one channel")
    return array


def _true_levels(path: Path, array: Array) -> Array:
    """Return PGM values as the file has them: Pillow spreads them over 16 bits."""
    with path.open("rb") as file:
        head = re.sub(rb"#[^\n]*", b"", file.read(1024))
    found = re.match(rb"P[25]\s+\d+\s+\d+\s+(\d+)\s", head)
    if not found or not 255 < (most := int(found[1])) < 65535:
        return array
    return np.round(array.astype(np.float64) * most / 65535).astype(np.uint16)


def _from_npz(path: Path, member: str | None) -> Array:
    with zipfile.ZipFile(path) as archive:
        names = [name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")]
        told = [name for name in names if name.lower() in ("depth", "distance", "z")]
        chosen = _named(member, names, path) if member is not None else _only(told if len(told) == 1 else names, path)
        with archive.open(f"{chosen}.npy") as file:
            return _read_npy(file, f"'{chosen}'", path)


def _read_npy(file: Any, name: str, path: Path) -> Array:
    """Read an array out of what unpacks it as it is read, which may claim any size. Raises FormatError."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran, dtype = read(file)
    count = int(np.prod(shape, dtype=object))
    if dtype.kind not in "fiu" or not 0 < count <= MAX_DEPTH_PIXELS:
        raise FormatError(f"{path}: {name} holds {dtype} of shape {shape}; expected numbers of shape (h, w)")
    data = file.read(count * dtype.itemsize)
    if len(data) < count * dtype.itemsize:
        raise FormatError(f"{path}: {name} announces more than the file holds")
    return np.frombuffer(data, dtype).reshape(shape, order="F" if fortran else "C").copy()


def _from_gzip(path: Path) -> Array:
    """Read a packed NPY file, as nerfstudio's ``ns-render`` leaves depth."""
    with gzip.open(path) as file:
        return _read_npy(file, "it", path)


def _from_exr(path: Path, member: str | None) -> Array:
    channels = exr_channels(path, MAX_DEPTH_PIXELS)
    return channels[_named(member, list(channels), path) if member is not None else depth_channel(channels, path)]


def depth_channel(channels: Mapping[str, Array], path: Path) -> str:
    """Return the name of the channel that holds depth. Raises FormatError when none does."""
    names = list(channels)
    for last in ("Z", "V"):
        if last in names:
            return last
        found = [name for name in names if name.endswith(f".{last}") and not _vector(name, names)]
        clear = [name for name in found if "mist" not in name.lower()] or found
        if clear:
            if len(clear) > 1:
                text = f"{path}: several channels may be depth, {', '.join(clear)}: the first is taken; --depth-channel NAME chooses"
                warn_of_input(text)
            return clear[0]
    if told := [name for name in names if re.search(r"(^|\.)(depth|distance)(\.[RY])?$", name, re.IGNORECASE)]:
        return told[0]
    layers = [name.removesuffix("R") for name in names if re.search(r"(^|\.)R$", name)]
    grey = [layer for layer in layers if _grey(channels, layer)]
    return f"{grey[0]}R" if len(grey) == 1 else _only(names, path)


def _vector(name: str, names: Sequence[str]) -> bool:
    """Return whether a channel Z is the third component of a vector: a normal, a position, a motion."""
    layer = name.rpartition(".")[0]
    return f"{layer}.X" in names and f"{layer}.Y" in names


def _grey(channels: Mapping[str, Array], layer: str) -> bool:
    """Return whether red, green and blue of a layer are the same."""
    return all(
        f"{layer}{other}" in channels and np.array_equal(channels[f"{layer}R"], channels[f"{layer}{other}"], equal_nan=True)
        for other in "GB"
    )


def _only(names: Sequence[str], path: Path) -> str:
    """Return the only name. Raises FormatError."""
    if len(names) == 1:
        return names[0]
    if not names:
        raise FormatError(f"{path}: holds no channel that can be read; it is damaged, or empty")
    shown = one_line(", ".join(names))
    raise FormatError(f"{path}: none of its channels is known as depth ({shown}); name one: --depth-channel NAME")


def _named(member: str, names: Sequence[str], path: Path) -> str:
    if member in names:
        return member
    raise FormatError(f"{path}: no channel '{member}'; it has {one_line(', '.join(names))}.{near_miss(member, names)}")
