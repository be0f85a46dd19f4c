"""Volumetric obscurance by line samples: how much of a sphere round the point is filled."""

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
from ..sampling.disk import Kernel
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Volumetric:
    """Volumetric obscurance: ``A = 1 - filled / whole``, summed over lines of sight through the upper half of a sphere.

    A line at offset ``o`` from the sphere's middle lies in it over ``2 h = 2 sqrt(R^2 - o^2)``; of that counts what lies above
    the tangent plane, and is filled what lies behind the depth buffer there. Lines come in pairs, opposite each other; one
    of which nothing is known (outside the image, or hidden by something more than a radius before the point) takes after
    its partner. Loos and Sloan, "Volumetric Obscurance", I3D 2010, with the surface normal; of its 9 lines the middle one
    is left out, which sees nothing but the point itself.
    """

    name: ClassVar[str] = "volumetric"
    shader: ClassVar[str] = "methods/volumetric.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH, "u_normal": NORMAL}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = noise.radius()
    pairs: int = setting(4, "pairs of lines a pixel", low=1, high=64)
    max_radius: float = noise.max_radius()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(max_reach=self.max_radius)

    def defines(self) -> Mapping[str, Define]:
        return {"PAIRS": self.pairs}

    def constants(self) -> Mapping[str, Any]:
        points = Kernel(count=self.pairs).points().astype(np.float64)
        half = np.sqrt(1 - (points**2).sum(1, keepdims=True))
        return {**noise.reach_uniforms(self.radius, self.max_radius), "u_lines": np.hstack([points, half]).astype(np.float32)}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_rotation": noise.tile_directions(math.pi / 2)}  # reflected, pairs turn by half a circle: all there is
