"""StarCraft II's ambient occlusion: points of the hemisphere, a falloff curve, several radii."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from ..graph.names import DEPTH, NORMAL
from ..sampling import noise
from ..sampling.sphere import reflection_planes, sphere_points
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Starcraft2:
    """StarCraft II's SSAO: points flipped into the normal's hemisphere, a curve of depth, the largest of several radii.

    ``A = 1 - max over radii of (1/N) sum f((z_s - z_q) / R)``; f is 0 up to 0, 1 up to ``full`` and
    ``1 - ((x - full) / (none - full))^power`` from there, 0 from ``none`` on. Filion, McNaughton, "StarCraft II: Effects and
    Techniques", SIGGRAPH 2008 course, which takes 8 to 32 samples and leaves the numbers of the curve to artists: ours
    count in full what lies within the radius before the sample, and nothing beyond two.

    Taps lie on texel centres. So that a plane stays open, what does not rise above the tangent plane (by ``bias``) occludes
    nothing; with exact taps it could not hide a point of the hemisphere. The course's depth at quarter size is not taken over.
    """

    name: ClassVar[str] = "starcraft2"
    shader: ClassVar[str] = "methods/starcraft2.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH, "u_normal": NORMAL}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {str(count): {"samples": count} for count in (8, 16, 32)}

    radius: float | None = noise.radius()
    samples: int = setting(16, "points of the hemisphere, for each radius", low=1, high=64)
    radii: int = setting(2, "how many; the largest occlusion counts", low=1, high=4)
    ratio: float = setting(0.25, "of each radius to the one before", above=0, high=1)
    full: float = setting(1.0, "depth before the sample that occludes in full", unit="radii", low=0, high=100)
    none: float = setting(2.0, "depth before the sample from which nothing occludes", unit="radii", above=0, high=1000)
    power: float = setting(1.0, "of the curve between full and none", above=0, high=16)
    bias: float = setting(0.01, "sine of the angle above the tangent plane that occluders must have", low=0, high=1)
    max_radius: float = noise.max_radius()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(max_reach=self.max_radius, taps_setting="samples")

    def defines(self) -> Mapping[str, Define]:
        return {"SAMPLES": self.samples, "RADII": self.radii}

    def constants(self) -> Mapping[str, Any]:
        return {
            **noise.reach_uniforms(self.radius, self.max_radius),
            "u_points": sphere_points(self.samples),
            "u_ratio": self.ratio,
            "u_curve": (self.full, 1 / max(self.none - self.full, 1e-6), self.power),
            "u_bias": self.bias,
        }

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_planes": reflection_planes(noise.TILE)}
