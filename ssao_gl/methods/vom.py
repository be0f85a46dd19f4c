"""Vicinity occlusion maps: mean depth over boxes, from a summed-area table."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from ..graph.names import DEPTH, DEPTH_RANGE, DEPTH_TABLE, NORMAL
from ..sampling import noise
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits

CORNER = math.sqrt(2)
"""Strength at which the corner of two walls is half occluded, seen along its bisector. There a slice at the angle phi to the
corner's normal plane sees the other wall rise by ``2 atan c``, ``c = |cos phi|``, so that the mean of half of its squared sine,
``2 c^2 / (1 + c^2)^2``, is ``1 / (2 sqrt 2)``."""

RATIO = 1 / 3
"""Width of each box over that of the one before: that of its middle block."""


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Vom:
    """Vicinity occlusion maps: what lies before the tangent plane in the mean over boxes around the pixel. No noise, no filter.

    ``A = 1 - (k/8) sum over 4 slices and their 2 sides of max over boxes of sin^2 a``, ``a`` the angle above the tangent plane
    of the mean depth over one of the 3 x 3 blocks of a box. Means are four look-ups in a summed-area table of inverse depth,
    which is affine over a plane: planes are open. Blocks that meet background do not count. After Diaz, Yela, Vazquez,
    "Vicinity Occlusion Maps: Enhanced Depth Perception of Volumetric Models", CGI 2008, which takes the mean over each box
    as a whole; that darkens all that lies near the outline of something in front (RMSE .15 for .10 on 18 views of
    640x360).

    Table and occlusion have a quarter of the image's width and height. Depth tells which texels count for a pixel.
    """

    name: ClassVar[str] = "vom"
    shader: ClassVar[str] = "methods/vom.frag"
    samplers: ClassVar[Mapping[str, str]] = {
        "u_z": DEPTH,
        "u_normal": NORMAL,
        "u_range": DEPTH_RANGE,
        "u_sums": DEPTH_TABLE,
    }
    exceptions: ClassVar[Mapping[str, Deviation]] = {
        "thin": Deviation(0.15, "a wire fills a block in part: its mean lies between wire and wall, as a wide thing would"),
    }
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = noise.radius()
    sizes: int = setting(3, "of boxes, each as wide as the middle block of the one before", low=1, high=6)
    intensity: float = setting(1.0, "strength; at 1 the corner of two walls is half occluded", low=0, high=16)
    fade: float = setting(0.5, "over which what lies beyond the radius stops to count", unit="radii", low=0, high=100)
    scale: int = setting(4, "pixels along each side of a texel of the table, and of occlusion", low=1, high=8)
    max_radius: float = noise.max_radius()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        inputs = frozenset({"depth", "normal", "depth_table"})
        return Traits(inputs=inputs, scale=self.scale, noise_tile=0, max_reach=self.max_radius)

    def defines(self) -> Mapping[str, Define]:
        return {"SIZES": self.sizes, "RATIO": RATIO}

    def constants(self) -> Mapping[str, Any]:
        reach = noise.reach_uniforms(self.radius, self.max_radius)
        return {**reach, "u_strength": self.intensity * CORNER, "u_per_fade": 1 / max(self.fade, 1e-6)}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {}
