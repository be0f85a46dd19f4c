"""Spheres as plain arrays: atoms, particles, points with a radius."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError
from .bounds import placed_bounds, similarity_scale

SKEW = 1e-4
"""Relative difference of lengths and angles up to which a transform counts as one that keeps spheres round."""


@dataclass(frozen=True, eq=False)
class Spheres:
    """Spheres that are drawn once for each of their transforms.

    centers: (n, 3) float32, in scene units relative to ``transforms``. radii: (n,) float32, or one number for all; a sphere of
    radius 0 is not seen. colors: (n, 4) uint8 sRGB, or None for ``color``: sRGB (r, g, b) in 0..1. transforms: (k, 4, 4)
    float64 model-to-world, turns, mirrors and uniform scales only. Raises SceneError for anything else.
    """

    centers: NDArray[np.float32]
    radii: NDArray[np.float32]
    colors: NDArray[np.uint8] | None = None
    transforms: NDArray[np.float64] = field(default_factory=lambda: np.eye(4)[None])
    name: str = ""
    color: tuple[float, float, float] = (0.8, 0.8, 0.8)

    def __post_init__(self) -> None:
        where = f"spheres '{self.name}'" if self.name else "spheres"
        c = np.asarray(self.centers, np.float32)
        if c.ndim != 2 or c.shape[1] != 3:
            raise SceneError(f"{where}: centers must be (n, 3), got {c.shape}")
        r = np.asarray(self.radii, np.float32)
        if r.ndim and r.shape != (len(c),):
            raise SceneError(f"{where}: radii must be one number or ({len(c)},), got {r.shape}")
        r = np.ascontiguousarray(np.broadcast_to(r, len(c)))
        if not np.isfinite(c).all():
            raise SceneError(f"{where}: {int((~np.isfinite(c)).any(1).sum())} centers are not finite numbers (NaN or infinity)")
        if not (np.isfinite(r).all() and (r >= 0).all()):
            raise SceneError(f"{where}: {int((~(np.isfinite(r) & (r >= 0))).sum())} radii are negative or not finite numbers")
        if self.colors is not None and (self.colors.shape != (len(c), 4) or self.colors.dtype != np.uint8):
            raise SceneError(f"{where}: colors must be ({len(c)}, 4) uint8, got {self.colors.shape} {self.colors.dtype}")
        k = np.asarray(self.transforms, np.float64)
        if k.ndim != 3 or k.shape[1:] != (4, 4) or not np.isfinite(k).all():
            raise SceneError(f"{where}: transforms must be finite and (k, 4, 4), got {k.shape}")
        if (bent := np.flatnonzero(~_keeps_round(k))).size:
            raise SceneError(f"{where}: transform {bent[0]} is no turn with a uniform scale; spheres would not stay round")
        for name, value in (("centers", np.ascontiguousarray(c)), ("radii", r), ("transforms", k)):
            object.__setattr__(self, name, value)

    @classmethod
    def from_points(
        cls, centers: ArrayLike, radii: ArrayLike, colors: NDArray[np.uint8] | None = None, *, name: str = ""
    ) -> Spheres:
        """Make spheres about centers (n, 3) of any size: what lies far from the origin keeps its 64-bit place."""
        points = np.asarray(centers, np.float64)
        place = np.eye(4)
        if points.ndim == 2 and points.shape[1] == 3 and len(points) and np.isfinite(points).all():
            place[:3, 3] = points.min(0) / 2 + points.max(0) / 2
            points = points - place[:3, 3]
        return cls(points.astype(np.float32), np.asarray(radii, np.float32), colors, place[None], name)

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(2, 3) smallest and largest world coordinate over all instances."""
        return placed_bounds(self.centers, self.transforms, self.radii)

    @property
    def is_placed(self) -> bool:
        """Whether there are some, and a place for them."""
        return bool(len(self.centers) and len(self.transforms))

    @property
    def can_show(self) -> bool:
        """Whether some have a size."""
        return self.is_placed and bool(self.radii.max() > 0)

    @property
    def piece_count(self) -> int:
        """Spheres of one instance."""
        return len(self.centers)

    def outline(self) -> NDArray[np.float32]:
        """Return the centers (n, 3)."""
        return self.centers

    def pieces(self, matrix: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return boxes (n, 2, 3) and areas (n,) of the spheres of an instance."""
        middle = self.centers.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        radii = self.radii.astype(np.float64)[:, None] * similarity_scale(matrix)
        return np.stack([middle - radii, middle + radii], 1), 4 * math.pi * radii[:, 0] ** 2


def _keeps_round(transforms: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether each transform (k, 4, 4) is a similarity: three columns of one length above 0, at right angles."""
    linear = transforms[:, :3, :3]
    length = np.linalg.norm(linear, axis=1).max(1)
    with np.errstate(all="ignore"):
        unit = linear / length[:, None, None]
        gram = unit.transpose(0, 2, 1) @ unit
    straight = (transforms[:, 3] == (0, 0, 0, 1)).all(1)
    return np.asarray(straight & (length > 0) & (np.abs(gram - np.eye(3)) < 2 * SKEW).all((1, 2)))
