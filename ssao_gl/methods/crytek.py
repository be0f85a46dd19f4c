"""The first screen-space ambient occlusion: points of a sphere against the depth buffer."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from ..graph.names import DEPTH
from ..sampling import noise
from ..sampling.sphere import reflection_planes, sphere_points
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits

_GREY = "half of the sphere round a point of a surface lies behind it"


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Crytek:
    """Crytek's SSAO: the share of the points of a sphere that the depth buffer does not hide, ``A = (1/N) sum [z_q >= z_s]``.

    Points ``s = p + R reflect(s_i, m)`` fill the sphere, each pixel reflecting them at another plane m of a 4x4 tile. Points
    outside the image, or hidden by something far before p (from one radius on, wholly from two), count 1/2, as on a
    plane. Mittring, "Finding Next Gen: CryEngine 2", SIGGRAPH 2007 course; range check after Kajalin, "Screen-Space
    Ambient Occlusion", ShaderX7, 2009.

    What that means: half of the sphere round a point on a plane lies behind it, so flat walls are grey, 1/2, and edges
    shine. ``doubled`` gives ``min(1, 2 A)``, as later games did: then planes are open but for the noise of the samples.
    """

    name: ClassVar[str] = "crytek"
    shader: ClassVar[str] = "methods/crytek.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": DEPTH}
    exceptions: ClassVar[Mapping[str, Deviation]] = {
        "plane": Deviation(0.8, "half the sphere lies behind the plane; near the border its nearer part is not in the image"),
        "radius": Deviation(0.6, f"{_GREY}, however small it is"),
        "convex": Deviation(0.6, _GREY),
        "step": Deviation(0.7, f"{_GREY}, and at the foot of a step more"),
        "lone texel": Deviation(0.25, "the texel hides the points behind it"),
        "thin": Deviation(0.6, _GREY),
        "monotone": Deviation(0.01, "over a few pixels the 16 points scatter about one half"),
    }
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {"raw": {"doubled": False}, "doubled": {"doubled": True}}

    radius: float | None = noise.radius()
    samples: int = setting(16, "points of the sphere", low=1, high=128)
    doubled: bool = setting(False, "twice the visibility, clamped: a plane is open")
    max_radius: float = noise.max_radius()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        return Traits(inputs=frozenset({"depth"}), max_reach=self.max_radius, taps_setting="samples")

    def defines(self) -> Mapping[str, Define]:
        return {"SAMPLES": self.samples}

    def constants(self) -> Mapping[str, Any]:
        reach = noise.reach_uniforms(self.radius, self.max_radius)
        return {**reach, "u_points": sphere_points(self.samples), "u_gain": 2.0 if self.doubled else 1.0}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {"u_planes": reflection_planes(noise.TILE)}
