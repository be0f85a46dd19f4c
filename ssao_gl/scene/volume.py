"""Volumes: a field sampled at voxels, and the surface or the opacities that are seen of it."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError, warn_of_input
from .bounds import box_corners
from .transfer import Transfer

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

DEFAULT_COLOR = (0.8, 0.8, 0.8)
"""sRGB, of an iso-surface."""

FLATTEST = 1e-6
"""Ratio of the shortest to the longest axis of a voxel below which an affine counts as singular."""

BINS = 256
"""Of the histogram that an automatic iso level is found by."""


@dataclass(frozen=True, eq=False)
class Volume:
    """Numbers at voxels, between which the field is trilinear, seen as the iso-surface ``iso`` or through ``transfer``.

    array: (x, y, z) real numbers; those that are not finite count as empty, with an InputWarning. affine: (4, 4), from
    voxel indices to scene units; voxel *centres* lie at whole indices, as in NIfTI and NRRD. Inside is what is at least
    ``iso``, in units of the data; with neither iso nor transfer the level is Otsu's (:func:`otsu_level`). Beyond the
    outermost voxels the field falls to its least value within one voxel, so that surfaces are closed. color: sRGB of the
    iso-surface. Raises SceneError for what has no surface: constant data, a level outside of them, a singular affine.
    """

    array: NDArray[Any]
    affine: F64 = field(default_factory=lambda: np.eye(4))
    _: KW_ONLY
    iso: float | None = None
    transfer: Transfer | None = None
    color: tuple[float, float, float] = DEFAULT_COLOR
    name: str = ""

    def __post_init__(self) -> None:
        where = f"volume '{self.name}'" if self.name else "volume"
        values, gaps = finite_values(self.array, where)
        if gaps:
            warn_of_input(f"{where}: {gaps:,} of {values.size:,} voxels are not finite numbers; taken as empty")
        object.__setattr__(self, "array", values)
        object.__setattr__(self, "affine", _checked_affine(self.affine, where))
        if self.iso is not None and self.transfer is not None:
            raise SceneError(f"{where}: has both iso and transfer; give one")
        low, high = self.range
        if low == high:
            raise SceneError(f"{where}: all voxels are {low:g}: without contrast there is no surface in it")
        if self.transfer is None:
            level = otsu_level(values) if self.iso is None else self.iso
            if not low < level <= high:
                raise SceneError(f"{where}: iso={level:g}: must be above {low:g} and at most {high:g}, the range of the data")
            object.__setattr__(self, "iso", float(level))

    @cached_property
    def range(self) -> tuple[float, float]:
        """Least and largest value."""
        return float(self.array.min()), float(self.array.max())

    def seen_as(self, iso: float | None, transfer: Transfer | None) -> Volume:
        """Return the same voxels as another surface; unchanged where neither is given. Raises SceneError."""
        return self if iso is None and transfer is None else replace(self, iso=iso, transfer=transfer)

    @cached_property
    def field(self) -> F32:
        """(z + 2, y + 2, x + 2) the padded field: voxel (x, y, z) lies at [z + 1, y + 1, x + 1].

        Of an iso-surface (value - iso) by the largest of its sizes, so inside is what is not negative; under a transfer function
        the value's place between least and largest, 0 to 1. Both fit 32-bit floats, whatever the data's unit.
        """
        low, high = self.range
        zero, unit = (low, high - low) if self.iso is None else (self.iso, max(self.iso - low, high - self.iso))
        padded = np.full(tuple(n + 2 for n in self.array.shape[::-1]), (low - zero) / unit, np.float32)
        inner = padded[1:-1, 1:-1, 1:-1]
        for z in range(inner.shape[0]):  # by slices: no second copy of the whole in 64-bit
            inner[z] = ((self.array[:, :, z].astype(np.float64) - zero) / unit).T
        if self.iso is not None:  # rounding must not move a voxel across the surface
            inside = np.moveaxis(self.array >= self.iso, (0, 1, 2), (2, 1, 0))
            np.copyto(inner, -np.finfo(np.float32).tiny, where=~inside & (inner >= 0))
        return padded

    @cached_property
    def occupied(self) -> NDArray[np.int64]:
        """(2, 3) first and end cell (x, y, z) of the box that holds all that is seen; cell c lies between voxels c and c + 1 of ``field``."""
        seen = self.field >= 0 if self.iso is not None else self.transfer_of().opaque(self.field)
        box = np.empty((2, 3), np.int64)
        for axis in range(3):
            along = np.flatnonzero(seen.any(tuple(a for a in range(3) if a != 2 - axis)))
            box[:, axis] = (along[0] - 1, along[-1] + 1) if len(along) else (0, self.field.shape[2 - axis] - 1)
        return np.clip(box, 0, np.array(self.field.shape[::-1]) - 1)

    def transfer_of(self) -> Transfer:
        """Return the transfer function over 0..1 of ``field``."""
        assert self.transfer is not None
        return self.transfer.over(*self.range)

    @cached_property
    def to_world(self) -> F64:
        """(4, 4) from coordinates (x, y, z) in ``field`` to the world."""
        moved = self.affine.copy()
        moved[:3, 3] -= self.affine[:3, :3].sum(1)
        return moved

    @property
    def transforms(self) -> F64:
        """(1, 4, 4): it is drawn once."""
        return self.affine[None]

    @cached_property
    def bounds(self) -> F64:
        """(2, 3) smallest and largest world coordinate of what may be seen."""
        return np.asarray(self.pieces(self.affine)[0][0])

    @property
    def is_placed(self) -> bool:
        """Whether it has a place: always."""
        return True

    @property
    def can_show(self) -> bool:
        """Whether something of it may be seen: not where a transfer function makes all of it transparent."""
        return self.iso is not None or bool(self.transfer_of().opaque(self.field).any())

    @property
    def piece_count(self) -> int:
        """One: it is a single thing."""
        return 1

    @property
    def contents(self) -> str:
        """What it is, in words."""
        seen = f"iso {self.iso:g}" if self.iso is not None else f"transfer function {self.transfer_of().name or 'of its own'}"
        return f"volume of {' x '.join(map(str, self.array.shape))}, {seen}"

    def outline(self) -> F32:
        """Return the corners (8, 3) of the box of what may be seen, as voxel indices."""
        return (box_corners(*self.occupied.astype(np.float64)) - 1).astype(np.float32)

    def pieces(self, matrix: F64) -> tuple[F64, F64]:
        """Return its box (1, 2, 3) in the world, and the box's area (1,)."""
        corners = (box_corners(*self.occupied.astype(np.float64)) - 1) @ matrix[:3, :3].T + matrix[:3, 3]
        box = np.stack([corners.min(0), corners.max(0)])
        x, y, z = box[1] - box[0]
        return box[None], np.array([2 * (x * y + y * z + z * x)])

    @property
    def voxel(self) -> float:
        """Shortest side of a voxel, scene units."""
        return float(np.linalg.norm(self.affine[:3, :3], axis=0).min())


def finite_values(values: ArrayLike, where: str = "volume") -> tuple[NDArray[Any], int]:
    """Return voxels (x, y, z) as real numbers, the least of them in place of what is not finite, and how many were not.

    Raises SceneError for arrays of another shape or kind.
    """
    array = np.asarray(values)
    if array.ndim != 3 or 0 in array.shape:
        choose = "; choose one volume, like array[..., 0]" if array.ndim == 4 else ""
        raise SceneError(f"{where}: must be an array (x, y, z), got shape {array.shape}{choose}")
    if array.dtype == bool:
        array = array.astype(np.uint8)
    if array.dtype.kind not in "uif":
        raise SceneError(f"{where}: voxels are {array.dtype}; expected real numbers")
    if array.dtype.kind != "f":
        return array, 0
    if array.dtype.itemsize == 2:
        array = array.astype(np.float32)
    good = np.isfinite(array)
    gaps = int(good.size - np.count_nonzero(good))
    if gaps == good.size:
        raise SceneError(f"{where}: not one voxel is a finite number")
    if gaps:
        array = np.where(good, array, array.min(where=good, initial=np.inf))
    if not math.isfinite(float(array.max()) - float(array.min())):
        raise SceneError(f"{where}: its values span more than 64-bit numbers hold")
    return array, gaps


def otsu_level(values: NDArray[Any]) -> float:
    """Return the level that parts the values into two classes with least spread (Otsu 1979); below their largest."""
    low, high = float(values.min()), float(values.max())
    counts, edges = np.histogram(values, BINS, (low, high))
    below, sums = np.cumsum(counts)[:-1].astype(np.float64), np.cumsum(counts * np.arange(BINS))[:-1]
    total, whole = float(counts.sum()), float(counts @ np.arange(BINS))
    above = total - below
    # The least and the largest value are in the first and the last bin, so neither class is empty.
    spread = below * above * (sums / below - (whole - sums) / above) ** 2
    best = np.flatnonzero(spread >= (1 - 1e-9) * spread.max())  # several where nothing lies between the classes
    return float(edges[1:-1][[best[0], best[-1]]].mean())


def _checked_affine(affine: ArrayLike, where: str) -> F64:
    try:
        matrix = np.array(affine, np.float64)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all() or not np.array_equal(matrix[3], (0, 0, 0, 1)):
        raise SceneError(f"{where}: affine must be a finite (4, 4) matrix whose last row is 0 0 0 1")
    sides = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if not sides[2] > FLATTEST * sides[0]:
        raise SceneError(f"{where}: its affine is singular: the axes of a voxel lie in one plane")
    return matrix
