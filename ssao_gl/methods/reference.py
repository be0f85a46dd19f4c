"""Screen-space truth: all that one depth buffer (or two layers) can say, with no sampling noise and no filter."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..graph.draws import Define
from ..graph.names import DEPTH, DEPTH_LAYER_2, NORMAL
from ..settings import setting, validate
from .base import Deviation
from .registry import register
from .traits import Traits


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """Exhaustive slices: every texel within the radius, 64 directions, the exact slice integral, a hard radius.

    The measure of each slice is that of Jimenez et al., "Practical Realtime Strategies for Accurate Indirect Occlusion",
    SIGGRAPH 2016 course; occluders are slabs behind what is seen as in Therrien et al. 2023 (128 bits of equal measure
    a slice), or infinitely thick (exact horizons). It is what the other screen-space methods approximate: their
    distance to it is sampling and filtering, its own distance to rays is what a depth buffer does not hold.
    """

    name: ClassVar[str] = "reference"
    shader: ClassVar[str] = "methods/reference.frag"
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    radius: float | None = setting(None, "reach of occlusion; none: from the camera or the scene", unit="scene units", above=0)
    thickness: float | None = setting(0.5, "of what a texel shows, behind it; none: infinite", unit="radii", above=0, high=1000)
    layers: int = setting(
        1, "2: also what lies directly behind (the renderer draws it; arrays and effects have one)", low=1, high=2
    )
    slices: int = setting(64, "directions through each pixel", low=1, high=1024)
    max_steps: int = setting(1024, "largest reach to each side", unit="pixels", low=1, high=16384)

    def __post_init__(self) -> None:
        validate(self)

    @property
    def traits(self) -> Traits:
        layers = {"second_layer"} if self.layers == 2 else set()
        few = dataclasses.replace(self, slices=min(self.slices, 2), max_steps=min(self.max_steps, 64))
        exhaustive = self.slices > 16 or self.max_steps > 512
        return Traits(
            inputs=frozenset({"depth", "normal", *layers}),
            max_reach=float(self.max_steps),
            taps_setting="slices",
            affordable=few if exhaustive else None,
        )

    @property
    def samplers(self) -> Mapping[str, str]:
        return {"u_z": DEPTH, "u_normal": NORMAL, **({"u_z2": DEPTH_LAYER_2} if self.layers == 2 else {})}

    def defines(self) -> Mapping[str, Define]:
        every: dict[str, Define] = {"SLICES": self.slices, "MAX_STEPS": self.max_steps}
        every |= {"SECOND_LAYER": 1} if self.layers == 2 else {}
        return every | ({"THICK": 1} if self.thickness is None else {})

    def constants(self) -> Mapping[str, Any]:
        if self.radius is None:
            raise SettingsError("the radius must be settled before the draw")
        return {"u_radius": self.radius, "u_thickness": self.thickness or 0.0}

    def tables(self, outputs: Collection[str] = ()) -> Mapping[str, NDArray[np.float32]]:
        return {}
