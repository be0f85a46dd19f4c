"""Horizon-based ambient occlusion: how far horizons rise above the tangent plane."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from ..graph.names import DEPTH, NORMAL
from ..sampling import noise
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Hbao:
    """Horizon-based ambient occlusion: ``A = 1 - mean over directions of sum W(d) (sin h - sin h before)``.

    Along each direction of the image the sum runs over the taps that raise the horizon, which starts at the tangent plane
    plus ``bias``; ``h`` is the elevation above the plane at right angles to the line of sight, ``W = 1 - (d/R)^2``. All
    elevations weigh the same (no cosine). Bavoil, Sainz, Dimitrov, "Image-Space Horizon-Based Ambient Occlusion", SIGGRAPH
    2008 talks: 6 directions of 6 steps, turned and shifted by a 4x4 tile. Taps on texel centres are slid into their
    direction along the surface, so that a plane stays a plane.
    """

    name: ClassVar[str] = "hbao"
    shader: ClassVar[str] = "methods/hbao.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH, "u_normal": NORMAL}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = noise.radius()
    directions: int = setting(6, "round each pixel", low=1, high=32)
    steps: int = setting(6, "taps a direction", low=1, high=64)
    bias: float = setting(
        math.pi / 18, "above the tangent plane; hides that round shapes have facets", unit="radians", low=0, high=1.5
    )
    intensity: float = setting(1.0, "strength", low=0, high=16)
    max_radius: float = noise.max_radius()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(max_reach=self.max_radius, taps_setting="steps")

    def defines(self) -> Mapping[str, Define]:
        return {"DIRECTIONS": self.directions, "STEPS": self.steps}

    def constants(self) -> Mapping[str, Any]:
        angle = 2 * math.pi / self.directions
        return {
            **noise.reach_uniforms(self.radius, self.max_radius),
            "u_next": (math.cos(angle), math.sin(angle)),
            "u_bias": (math.cos(self.bias), math.sin(self.bias)),
            "u_strength": self.intensity / self.directions,
        }

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_noise": noise.tile_directions(2 * math.pi / self.directions)}
