"""Volume files: NRRD by pynrrd and NIfTI by nibabel, with what their headers claim checked before anything is allocated.

The world of a file that names anatomical axes is RAS in its units, x to the patient's right, y to the front, z up: what
NIfTI's affine gives; the LPS and LAS spaces of NRRD are turned into it. Other files keep their own axes.
"""

from __future__ import annotations

import bz2
import gzip
import io
import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, encodable, one_line
from ..io.memory import free_memory
from ..scene.volume import Volume, finite_values
from .notes import Notes
from .read_options import VolumeOptions

VOLUMES = (".nrrd", ".nhdr", ".nii", ".nii.gz")
"""Endings of volumes' names."""
MAX_VOXELS = 1 << 31
"""Their field takes 8 GiB as it is drawn."""
VOXEL_BYTES = 24
"""Of the field, of the driver's own, and of what is made on the way to either."""

DONE = ("data file", "datafile", "line skip", "lineskip")
"""Fields of a NRRD header that say how to come to its data."""

Stored = tuple[NDArray[Any], NDArray[np.float64]]

TO_RAS: Mapping[str, tuple[int, int, int]] = {
    "right-anterior-superior": (1, 1, 1), "ras": (1, 1, 1),
    "left-anterior-superior": (-1, 1, 1), "las": (-1, 1, 1),
    "left-posterior-superior": (-1, -1, 1), "lps": (-1, -1, 1),
}  # fmt: skip
"""NRRD's anatomical spaces -> signs that turn them into RAS."""


def is_volume(name: str) -> bool:
    """Whether a file of this name is read as a volume."""
    return name.lower().endswith(VOLUMES)


def read_volume(path: Path, options: VolumeOptions, notes: Notes) -> Volume:
    """Return the volume of a file. Raises SceneError, and whatever else the libraries are led into."""
    nrrd_file = path.suffix.lower() in (".nrrd", ".nhdr")
    array, affine = _read_nrrd(path, options, notes) if nrrd_file else _read_nifti(path, options, notes)
    values, gaps = finite_values(array)
    if gaps:
        notes.add(f"{gaps:,} of {values.size:,} voxels are not finite numbers; taken as empty")
    volume = Volume(values, affine, iso=options.iso, transfer=options.transfer, name=encodable(path.name))
    if options.iso is None and options.transfer is None:
        low, high = volume.range
        notes.add(f"shown at iso={volume.iso:.4g}, by Otsu's method, of data from {low:g} to {high:g}; choose with --iso")
    return volume


def _read_nifti(path: Path, options: VolumeOptions, notes: Notes) -> Stored:
    try:
        import nibabel
    except ImportError:
        raise SceneError("reading NIfTI files needs the package nibabel: pip install 'ssao_gl[volumes]'") from None
    image: Any = nibabel.load(path)
    if type(image).__name__ not in ("Nifti1Image", "Nifti2Image"):
        raise SceneError(f"is no NIfTI file but {type(image).__name__}; save it as .nii")
    kind = image.get_data_dtype()
    if kind.kind not in "uif":
        raise SceneError(f"holds {one_line(kind, 60)}; expected one real number a voxel")
    shape, frame = _chosen_frame(image.shape, options)
    if not path.name.lower().endswith(".gz"):
        offset, need = int(image.dataobj.offset), math.prod(image.shape) * kind.itemsize
        _check_bytes(path.stat().st_size - offset, need, image.shape, kind.name)
    if not (image.header["qform_code"] or image.header["sform_code"]):
        notes.add(
            "its header gives no orientation (qform and sform codes are 0): drawn along its own axes, x mirrored as nibabel does"
        )
    data = image.dataobj[frame]  # of the frame alone, scaled by scl_slope and scl_inter
    return np.asarray(data).reshape(shape), np.asarray(image.affine, np.float64)


def _read_nrrd(path: Path, options: VolumeOptions, notes: Notes) -> Stored:
    try:
        import nrrd
    except ImportError:
        raise SceneError("reading NRRD files needs the package pynrrd: pip install 'ssao_gl[volumes]'") from None
    with path.open("rb") as file:
        header = nrrd.read_header(file)
        missing = [name for name in ("type", "dimension", "sizes", "encoding") if name not in header]
        if missing:
            raise SceneError(f"its header lacks '{missing[0]}'")
        sizes = [int(n) for n in header["sizes"]]
        spatial = _spatial_axes(header, len(sizes), options)
        kind = _element_type(header)
        _check_count([sizes[axis] for axis in spatial], math.prod(sizes) * kind.itemsize)
        need = math.prod(sizes) * kind.itemsize + max(int(header.get("byte skip", header.get("byteskip", 0))), 0)
        data = _payload(path, file, header, need)
    header = {name: value for name, value in header.items() if name not in DONE}
    array = nrrd.read_data(header | {"encoding": _plain(header["encoding"])}, data)
    affine = _nrrd_affine(header, spatial, notes)
    if len(sizes) == 4:
        frame_axis = next(axis for axis in range(4) if axis not in spatial)
        array = np.take(array, options.frame or 0, frame_axis)
    return array, affine


def _element_type(header: Mapping[str, Any]) -> np.dtype[Any]:
    from nrrd.reader import _TYPEMAP_NRRD2NUMPY as TYPES

    name = str(header["type"])
    if TYPES.get(name, "V") == "V":
        raise SceneError(f"its type '{one_line(name, 40)}' is not read; expected a number, like short or float")
    kind: np.dtype[Any] = np.dtype(TYPES[name])
    if kind.itemsize > 1 and "endian" not in header and _plain(header["encoding"]) == "raw":
        raise SceneError(
            "its header lacks 'endian', so the order of its bytes is unknown; add 'endian: little' or 'endian: big'"
        )
    return kind


def _plain(encoding: str) -> str:
    """Return how data are written once they are unpacked."""
    text = str(encoding).lower() in ("ascii", "text", "txt")
    return "ascii" if text else "raw"


def _payload(path: Path, file: BinaryIO, header: Mapping[str, Any], need: int) -> BinaryIO:
    """Return the unpacked data of a file, attached or detached. Raises SceneError."""
    encoding, name = str(header["encoding"]).lower(), header.get("data file", header.get("datafile"))
    openers: Mapping[str, Callable[[BinaryIO], Any]] = {
        "raw": lambda f: f, "ascii": lambda f: f, "text": lambda f: f, "txt": lambda f: f,
        "gzip": lambda f: gzip.GzipFile(fileobj=f), "gz": lambda f: gzip.GzipFile(fileobj=f),
        "bzip2": bz2.BZ2File, "bz2": bz2.BZ2File,
    }  # fmt: skip
    if encoding not in openers:
        raise SceneError(f"its encoding '{one_line(encoding, 40)}' is not read; expected raw, gzip, bzip2 or ascii")
    with nullcontext(file) if name is None else _detached(path, str(name)).open("rb") as source:
        for _ in range(int(header.get("line skip", header.get("lineskip", 0)))):
            source.readline()
        return _unpacked(openers[encoding](source), encoding, need, header)


def _unpacked(stream: Any, encoding: str, need: int, header: Mapping[str, Any]) -> BinaryIO:
    if _plain(encoding) == "ascii":
        return io.BytesIO(stream.read())
    at_end = int(header.get("byte skip", header.get("byteskip", 0))) == -1
    try:
        # No more than the header asks for, whatever a packed file would unpack to; with byte skip -1 the data are the last.
        data = stream.read() if at_end and encoding == "raw" else stream.read(need)
    except (EOFError, zlib.error, OSError) as error:
        raise SceneError(f"its packed data are damaged ({one_line(error, 80)})") from None
    _check_bytes(len(data), need, [int(n) for n in header["sizes"]], str(header["type"]))
    return io.BytesIO(data)


def _detached(path: Path, name: str) -> Path:
    """Return the data file of a detached header, which lies beside it. Raises SceneError for one elsewhere."""
    if name.upper().startswith("LIST") or "%" in name:
        raise SceneError(
            f"its data lie in several files ('{one_line(name, 60)}'), which is not read; join them, as unu save does"
        )
    parts = PurePosixPath(name.replace("\\", "/"))
    folder = path.parent.resolve()
    beside = (folder / parts).resolve()
    if parts.is_absolute() or not beside.is_relative_to(folder):
        raise SceneError(f"its data file '{one_line(name, 120)}' lies outside the header's folder, where nothing is read")
    if not beside.is_file():
        raise SceneError(f"its data file '{one_line(name, 120)}' is not there; it must lie beside the header")
    return beside


def _spatial_axes(header: Mapping[str, Any], dimension: int, options: VolumeOptions) -> list[int]:
    """Return which three axes are those of space. Raises SceneError where there are not just three, and at most one beside them."""
    sizes = [int(n) for n in header["sizes"]]
    if len(sizes) != dimension or int(header["dimension"]) != dimension or min(sizes, default=0) < 1:
        raise SceneError(f"its dimension is {header['dimension']} and its sizes are {sizes}; expected as many, each at least 1")
    if dimension == 3:
        kinds = header.get("kinds") or []
        if any("color" in str(one).lower() or "vector" in str(one).lower() for one in kinds):
            raise SceneError("one of its axes holds colours or vectors; expected one real number a voxel")
        _check_frame(1, options, sizes)
        return [0, 1, 2]
    directions = header.get("space directions")
    if dimension == 4:
        spatial = [] if directions is None else [axis for axis in range(4) if not _is_none(directions[axis])]
        spatial = spatial if len(spatial) == 3 else [0, 1, 2]
        other = next(axis for axis in range(4) if axis not in spatial)
        _check_frame(sizes[other], options, sizes)
        return spatial
    raise SceneError(f"has {dimension} axes ({' x '.join(map(str, sizes))}); expected 3, or 4 with a frame chosen by --frame")


def _is_none(direction: Any) -> bool:
    return direction is None or bool(np.isnan(np.asarray(direction, np.float64)).any())


def _nrrd_affine(header: Mapping[str, Any], spatial: Sequence[int], notes: Notes) -> NDArray[np.float64]:
    """Return the (4, 4) affine to RAS, or to the file's own axes where it names none."""
    matrix = np.eye(4)
    directions = header.get("space directions")
    if directions is not None:
        columns = [directions[axis] for axis in spatial]
        if any(_is_none(column) for column in columns):
            raise SceneError("its 'space directions' leave out axes of space; expected three vectors")
        matrix[:3, :3] = np.array([np.asarray(column, np.float64) for column in columns]).T
    elif header.get("spacings") is not None:
        spacings = np.asarray(header["spacings"], np.float64)[list(spatial)]
        if not np.isfinite(spacings).all():
            notes.add("its spacings are not all numbers; taken as 1 where they are not")
        matrix[:3, :3] = np.diag(np.where(np.isfinite(spacings), spacings, 1.0))
    if header.get("space origin") is not None:
        matrix[:3, 3] = np.asarray(header["space origin"], np.float64)
    signs = TO_RAS.get(str(header.get("space", "")).lower(), (1, 1, 1))
    return np.diag([*map(float, signs), 1.0]) @ matrix


def _chosen_frame(shape: Sequence[int], options: VolumeOptions) -> tuple[tuple[int, ...], tuple[Any, ...]]:
    """Return the three sizes of a NIfTI image, and the index of what is read of it. Raises SceneError."""
    sizes = [int(n) for n in shape]
    if any(n < 1 for n in sizes) or len(sizes) < 2:
        raise SceneError(f"its sizes are {' x '.join(map(str, sizes))}; expected 3, each at least 1")
    while len(sizes) > 3 and sizes[-1] == 1:
        sizes.pop()
    if len(sizes) > 4:
        raise SceneError(
            f"has {len(sizes)} axes ({' x '.join(map(str, sizes))}); expected 3, or 4 with a frame chosen by --frame"
        )
    _check_count(sizes[:3], math.prod(sizes[:3]) * 8)
    last: tuple[Any, ...] = ()
    if len(sizes) == 4:
        _check_frame(sizes[3], options, sizes)
        last = (options.frame or 0,)
    else:
        _check_frame(1, options, sizes)
    three = tuple((sizes + [1])[:3])
    return three, (*[slice(None)] * min(len(sizes), 3), *last, *[0] * (len(shape) - min(len(sizes), 3) - len(last)))


def _check_frame(frames: int, options: VolumeOptions, sizes: Sequence[int]) -> None:
    if options.frame is None and frames > 1:
        raise SceneError(
            f"has {frames} frames of volumes ({' x '.join(map(str, sizes))}); choose one by --frame 0 to {frames - 1}"
        )
    if options.frame is not None and not 0 <= options.frame < frames:
        known = "0" if frames == 1 else f"0 to {frames - 1}"
        raise SceneError(f"has {frames} frame{'s' * (frames > 1)}; --frame {options.frame} must be {known}")


def _check_count(sizes: Sequence[int], stored: int) -> None:
    """Raise SceneError for more voxels than can be held. ``stored``: bytes of what is read of the file."""
    shape, count = " x ".join(map(str, sizes)), math.prod(sizes)
    if count > MAX_VOXELS:
        raise SceneError(f"has {shape} voxels; at most {MAX_VOXELS:,} are drawn: take every second one")
    need, have = stored + count * VOXEL_BYTES, free_memory()
    if need > have:
        raise SceneError(
            f"has {shape} voxels, which take {need / 2**30:.1f} GiB of memory, but {have / 2**30:.1f} GiB are free: take every second one"
        )


def _check_bytes(have: int, need: int, sizes: Sequence[int], kind: str) -> None:
    if have < need:
        raise SceneError(
            f"is cut short: {' x '.join(map(str, sizes))} voxels of {kind} need {need:,} bytes of data, there are {max(have, 0):,}"
        )
