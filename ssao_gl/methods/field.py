"""Cones through the occupancy of the scene: spheres, volumes and triangles in one field of voxels."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..graph.draws import Define
from ..graph.names import FIELD, FIELD_COARSE, PIXEL_DEPTH, PIXEL_NORMAL
from ..occupancy.grid import LEVELS
from ..sampling import noise
from ..sampling.disk import GOLDEN_ANGLE, bayer
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits

START = 0.5
"""Of the first step, in finest voxels."""


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class OccupancyField:
    """Cones through one field of voxels, whatever fills it: ``A = 1 - mean over cones of max over steps of what a voxel hides``.

    Cones lie as cosine-weighted directions do, and turn from pixel to pixel. A voxel's opacity counts as far as it exceeds the share of
    the voxel that lies below the tangent plane, which may be the surface's own: planes are open. Voxels become coarser along a cone,
    and keep their opacity along each axis, after Crassin et al., "Interactive Indirect Illumination Using Voxel Cone Tracing",
    Pacific Graphics 2011; where they are not small beside the spheres, or are translucent, what one cone meets adds up as
    independent things do. The field itself is made once for a scene and a size of voxels, and knows no view.
    """

    name: ClassVar[str] = "field"
    shader: ClassVar[str] = "methods/field.frag"
    samplers: ClassVar[Mapping[str, str]] = {
        "u_pixel_z": PIXEL_DEPTH,
        "u_pixel_normal": PIXEL_NORMAL,
        "u_field": FIELD,
        "u_coarse": FIELD_COARSE,
    }
    exceptions: ClassVar[Mapping[str, Deviation]] = {
        "rotation": Deviation(
            0.6,
            "voxels keep the axes of the world: a scene turned by no quarter falls into others, and is as dark only in the mean",
        ),
    }
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {"medium": {}, "high": {"cones": 8}}

    radius: float | None = noise.radius()
    cones: int = setting(4, "cones a pixel", low=1, high=64)
    width: float = setting(0.7, "of a voxel over its distance, about", low=0.05, high=4)
    detail: float = setting(24.0, "voxels to the radius, where memory allows", low=2, high=128)
    voxel: float | None = setting(None, "side of a voxel; none: by detail, or larger", unit="scene units", above=0)
    scale: int = setting(
        1, "1, 2 or 4: pixels of the image along each side of a pixel for which occlusion is drawn", low=1, high=4
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.scale == 3:
            raise SettingsError("field.scale=3: must be one of 1, 2, 4")

    @property
    def traits(self) -> Traits:
        return Traits(
            inputs=frozenset({"depth", "normal", "prepared"}),
            scale=self.scale,
            taps=self.cones,
            taps_setting="cones",
            affordable=dataclasses.replace(self, detail=min(self.detail, 6.0)),
            max_reach=1.0,  # of the image a pixel sees itself alone
        )

    @property
    def side(self) -> float:
        """Of a finest voxel, scene units. Raises SettingsError when the radius is not settled."""
        if self.radius is None:
            raise SettingsError("the radius must be settled before the draw")
        return self.voxel or self.radius / self.detail

    def steps(self) -> NDArray[np.float64]:
        """Return (n, 3) distance and length in finest voxels, and level, coarser levels last: each as long as its voxels, the last as far as the radius."""
        side = self.side
        reach, at = (self.radius or side) / side, START
        found: list[tuple[float, float, int]] = []
        while at < reach or not found:
            left = max(reach - at, 0.0)
            level = round(math.log2(max(min(self.width * at, left), 1.0)))
            level = min(level, LEVELS)
            length = left if left < 1.5 * 2**level else 2.0**level
            found.append((at, length, level))
            at += max(length, 1e-6)
        return np.array(sorted(found, key=lambda step: step[2]))

    def defines(self) -> Mapping[str, Define]:
        counts = np.bincount(self.steps()[:, 2].astype(int), minlength=LEVELS + 1)
        steps = {f"STEPS_{level}": int(count) for level, count in enumerate(counts)}
        return {"CONES": self.cones, "STEPS": int(counts.sum()), **steps}

    def constants(self) -> Mapping[str, Any]:
        at, length, level = self.steps().T
        angle = np.arange(self.cones) * GOLDEN_ANGLE
        return {
            "u_noise_width": float(noise.TILE),
            "u_steps": np.column_stack([at, length, 2.0**-level, np.minimum(length / 2.0**level, 1)]).astype(np.float32),
            "u_turns": np.column_stack([np.cos(angle), np.sin(angle)]).astype(np.float32),
        }

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        """Return turns, places in rings and places of steps, each stratified over the tile, in orders that set them apart."""
        count = noise.TILE**2
        order = bayer(noise.TILE).reshape(noise.TILE, noise.TILE)
        angle = (order + 0.5) / count * 2 * math.pi
        ring, place = ((order * k % count + 0.5) / count for k in (7, 11))
        return {"u_noise": np.stack([np.cos(angle), np.sin(angle), ring, place], -1).astype(np.float32)}
