"""Scalable ambient obscurance: Alchemy's estimator with a smooth falloff, on a spiral."""

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
from ..sampling.disk import Rotation
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Sao:
    """Scalable ambient obscurance: ``A = max(0, 1 - 5 sigma / (N R^6) sum max(0, R^2 - v.v)^3 max(0, v.n - b) / (v.v + eps))``.

    Taps lie on a spiral, tap i at ``(i + 1/2) / N`` of the radius and as much of all turns. McGuire, Mara, Luebke,
    "Scalable Ambient Obscurance", HPG 2012; samples, turns, ``sigma = 1``, ``b = 0.01`` and ``eps = 0.01`` are those of its
    published shader, which are for a radius of 1 m: here they are shares of the radius (sigma and b) and of its square
    (eps), so that any scene unit gives the same picture. Not taken over: the mip pyramid of depth, which only saves
    memory traffic, and the hash that turns the spiral, in whose place is a tile that the filter averages away.
    """

    name: ClassVar[str] = "sao"
    shader: ClassVar[str] = "methods/sao.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH, "u_normal": NORMAL}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = noise.radius()
    samples: int = setting(11, "taps a pixel", low=1, high=128)
    turns: int = setting(7, "of the spiral; no divisor in common with the taps", low=1, high=128)
    intensity: float = setting(1.0, "sigma over the radius", low=0, high=16)
    bias: float = setting(0.01, "raise it if flat surfaces speckle", unit="radii", low=0, high=1)
    max_radius: float = noise.max_radius()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(max_reach=self.max_radius, taps_setting="samples")

    def defines(self) -> Mapping[str, Define]:
        return {"SAMPLES": self.samples}

    def constants(self) -> Mapping[str, Any]:
        length = (np.arange(self.samples) + 0.5) / self.samples
        angle = length * self.turns * 2 * math.pi
        spiral = np.stack([length * np.cos(angle), length * np.sin(angle)], 1).astype(np.float32)
        reach = noise.reach_uniforms(self.radius, self.max_radius)
        return {**reach, "u_spiral": spiral, "u_bias": self.bias, "u_strength": 5 * self.intensity}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_rotation": Rotation(tile=noise.TILE).vectors()}
