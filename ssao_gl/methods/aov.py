"""Ambient occlusion volumes: every triangle darkens the pixels near to it by its closed-form share of their hemispheres."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..graph.draws import Define
from ..graph.names import HIDDEN, PIXEL_DEPTH
from ..sampling import noise
from ..settings import setting, validate
from . import element_settings
from .base import Deviation
from .registry import register
from .traits import ElementTraits, Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class OcclusionVolumes:
    """Ambient occlusion volumes: ``A = C(sum over triangles of g F)``. Needs the scene; no noise, no filter.

    ``F`` is the form factor of the triangle, cut off at the pixel's horizon (Lambert's sum over edges). ``g`` falls from 1 on the
    triangle to 0 at a radius ``R`` from it: ``(1 - h/R)^p`` times ``1 - m/R`` for each edge that the pixel lies beside by
    ``m > 0``, ``h`` its height above the triangle. ``C`` makes up for what triangles hide twice: ``exp(-x)``, or ``1 - x`` without.
    McGuire, "Ambient Occlusion Volumes", HPG 2010.

    Time goes with what the volumes fill, which grows with the radius squared times the number of triangles: a setting where that is too much
    is refused. A triangle that alpha cuts out in part hides that much less, all over. Spheres and volumes hide nothing.
    """

    name: ClassVar[str] = "aov"
    shader: ClassVar[str] = "methods/aov.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_pixel_z": PIXEL_DEPTH, "u_hidden": HIDDEN}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = noise.radius()
    power: float = setting(1.0, "p of the falloff above a triangle; 1 as published", low=0, high=16)
    sides: str = setting(
        "both", "where a triangle darkens: on its front alone, as published, or on both sides", choices=("both", "front")
    )
    compensation: str = setting("exp", "for what hides the same directions: C of the sum", choices=("exp", "none"))
    intensity: float = setting(1.0, "strength: a factor of the sum", low=0, high=16)
    scale: int = element_settings.scale()
    sums: str = element_settings.sums()
    max_fill: float = element_settings.max_fill()

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        elements = ElementTraits(
            "triangles", self.sums == "float", 1e6 * self.max_fill, {"u_power": self.power}, both_sides=self.sides == "both"
        )
        return Traits(inputs=frozenset({"depth", "scene"}), scale=self.scale, noise_tile=0, max_reach=1.0, elements=elements)

    def defines(self) -> Mapping[str, Define]:
        return {"COMPENSATION": int(self.compensation == "exp")}

    def constants(self) -> Mapping[str, Any]:
        return {"u_strength": self.intensity}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {}
