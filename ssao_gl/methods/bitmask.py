"""Visibility bitmasks over slices of the hemisphere, with sectors of equal cosine-weighted measure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..kernel import bayer
from ..settings import setting, validate
from ..sources import Define
from ..view import View
from . import Deviation, register

TILE = 4
"""Width of the noise tile, in pixels: what the default filter averages away."""


@register
@dataclass(frozen=True, slots=True, kw_only=True)
class Bitmask:
    """Slices whose occluders are slabs, kept in 32 bits of equal measure; a hard radius.

    After Therrien, Levesque, Gilet, "Screen Space Indirect Lighting with Visibility Bitmask", 2023. There the sectors are
    equal in angle, which is not the measure of cosine-weighted occlusion; here each stands for the same share of the
    slice integral of Jimenez et al., "Practical Realtime Strategies for Accurate Indirect Occlusion", 2016. Slices are
    averaged by their weights, so a plane is exactly open at any tilt; taps outside the image hide nothing.
    """

    name: ClassVar[str] = "bitmask"
    shader: ClassVar[str] = "methods/bitmask.frag"
    samplers: ClassVar[Mapping[str, str]] = {"u_z": "z", "u_normal": "normal"}
    exceptions: ClassVar[Mapping[str, Deviation]] = {}
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "draft": {"steps": 3},
        "low": {"steps": 5},
        "medium": {"steps": 8},
        "high": {"slices": 2, "steps": 12},
        "ultra": {"slices": 3, "steps": 24},
    }

    radius: float | None = setting(None, "reach of occlusion; none: from the camera or the scene", unit="scene units", above=0)
    slices: int = setting(1, "directions through each pixel", low=1, high=16)
    steps: int = setting(8, "taps to each side of a slice", low=1, high=64)
    thickness: float = setting(0.4, "of what a texel shows, behind it", unit="radii", low=0, high=1000)
    bridge: float = setting(1.5, "thickness added per distance to the next tap, so that slabs leave no gaps", low=0, high=1000)
    max_radius: float = setting(
        256.0, "largest footprint; nearer surfaces get a smaller reach", unit="pixels", low=1, high=4096
    )

    def __post_init__(self) -> None:
        validate(self)

    def defines(self) -> Mapping[str, Define]:
        return {"SLICES": self.slices, "STEPS": self.steps}

    def uniforms(self, view: View) -> Mapping[str, Any]:
        angle = math.pi / self.slices
        return {
            "u_radius": self.radius,
            "u_thickness": (self.thickness, self.bridge),
            "u_max_radius": self.max_radius,
            "u_noise_width": float(TILE),
            "u_next_slice": (math.cos(angle), math.sin(angle)),
        }

    def lookups(self) -> Mapping[str, NDArray[np.float32]]:
        """Directions and step offsets, both stratified over the tile and in an order that sets neighbours apart."""
        order = bayer(TILE).reshape(TILE, TILE)
        angle = (order + 0.5) / TILE**2 * math.pi / self.slices
        offset = (order * 7 % TILE**2 + 0.5) / TILE**2
        return {"u_noise": np.stack([np.cos(angle), np.sin(angle), offset, np.zeros_like(offset)], -1).astype(np.float32)}
