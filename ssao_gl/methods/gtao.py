"""Ground-truth ambient occlusion as XeGTAO samples it."""

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
class Gtao:
    """Ground-truth ambient occlusion: the cosine-weighted integral between the two horizons of each slice, in closed form.

    ``A = mean over slices of |N_s| (a(h1) + a(h2))``, ``a(h) = (cos g + 2 h sin g - cos(2 h - g)) / 4`` with g the angle of
    the projected normal and h1, h2 the horizons from the viewer; occluders are infinitely thick. Jimenez, Wu, Pesce, Jarabo,
    "Practical Realtime Strategies for Accurate Indirect Occlusion", SIGGRAPH 2016 course.

    Sampling, heuristics and presets are those of XeGTAO 1.30 (Strugar, McCalla; Intel 2021): radius times 1.457, taps at
    squared steps from 1.3 pixels on, shifted by the golden ratio; over the last 61.5 % of the radius horizons fade to the
    edge of the hemisphere; |N_s| lifted by 5 % of the way to 1; up to 0.05 brighter where the radius is under 10 pixels;
    finally the power 2.2, and 0.03 at least. Not taken over: the plain mean, which over few slices scatters about 1 on a
    plane (0.28 to 1.52 for one) and would be cut off there before the filter: here slices are averaged by what each is
    without occluders, lift not counted; the mip pyramid of depth, which saves memory traffic on GPUs and costs time in
    software; and the noise, in whose place is a 4x4 tile that the filter here averages away. Taps on texel centres are
    slid into their slice along the surface, so that a plane stays a plane.
    """

    name: ClassVar[str] = "gtao"
    shader: ClassVar[str] = "methods/gtao.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH, "u_normal": NORMAL}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "low": {"slices": 1, "steps": 2},
        "medium": {"slices": 2, "steps": 2},
        "high": {"slices": 3, "steps": 3},
        "ultra": {"slices": 9, "steps": 3},
    }

    radius: float | None = noise.radius()
    slices: int = setting(3, "directions through each pixel", low=1, high=64)
    steps: int = setting(3, "taps to each side of a slice", low=1, high=64)
    radius_multiplier: float = setting(1.457, "of the radius, against biases of screen space", above=0, high=10)
    falloff: float = setting(0.615, "last part of the radius, over which occluders fade", unit="radii", low=0.001, high=1)
    thin: float = setting(0.0, "distances in depth count more by this share: occluders are not that thick", low=0, high=0.7)
    lift: float = setting(0.05, "of the slices' weights towards 1", low=0, high=1)
    power: float = setting(2.2, "contrast, applied last", above=0, high=16)
    max_radius: float = noise.max_radius()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(max_reach=self.max_radius, taps=self.slices * self.steps, taps_setting="slices")

    def defines(self) -> Mapping[str, Define]:
        return {"SLICES": self.slices, "STEPS": self.steps}

    def constants(self) -> Mapping[str, Any]:
        angle = math.pi / self.slices
        radius = None if self.radius is None else self.radius * self.radius_multiplier
        return {
            **noise.reach_uniforms(radius, self.max_radius),
            "u_next_slice": (math.cos(angle), math.sin(angle)),
            "u_per_falloff": 1 / self.falloff,
            "u_thin": 1 + self.thin,
            "u_lift": self.lift,
            "u_power": self.power,
        }

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_noise": noise.tile_directions(math.pi / self.slices)}
