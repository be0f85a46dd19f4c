"""Materials: base colour and alpha of a surface, and how it shines (glTF 2.0, 3.9)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from . import srgb

AlphaMode = Literal["OPAQUE", "MASK", "BLEND"]
Wrap = Literal["repeat", "mirror", "clamp"]
Color = tuple[float, float, float]

SOLID_FROM = 0.5
"""Alpha from which what would be mixed with its background is drawn solid."""


@dataclass(frozen=True, eq=False)
class ColorTexture:
    """A picture of base colour: ``array`` (h, w, 3 or 4) uint8, sRGB with linear alpha, row 0 on top, which is v = 0.

    wrap: what u and v do outside 0..1. nearest: texels are not blended where they are magnified. mipmaps: smaller copies
    are used where they are minified. linear: numbers and no colours, not encoded as sRGB.
    """

    array: NDArray[np.uint8]
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    nearest: bool = False
    mipmaps: bool = True
    name: str = ""
    linear: bool = False

    def __post_init__(self) -> None:
        a = self.array
        if a.ndim != 3 or a.shape[2] not in (3, 4) or a.dtype != np.uint8 or 0 in a.shape:
            raise SceneError(f"texture '{self.name}': must be uint8 of shape (h, w, 3 or 4), got {a.dtype} {a.shape}")
        if any(kind not in ("repeat", "mirror", "clamp") for kind in self.wrap):
            raise SceneError(f"texture '{self.name}': wrap is {self.wrap}; each must be repeat, mirror or clamp")

    @cached_property
    def alpha_range(self) -> tuple[float, float]:
        """Smallest and largest alpha of a texel, in 0..1."""
        return alpha_range(self.array[..., 3]) if self.array.shape[2] == 4 else (1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface looks: base colour = ``base_color`` x texture x vertex colours, multiplied as linear light.

    base_color: linear (r, g, b, alpha) in 0..1. alpha_mode: OPAQUE ignores alpha; MASK cuts out what is below
    ``alpha_cutoff``; BLEND, which would mix with what is behind, cuts out what is below 1/2. metallic and
    roughness are what ``Settings.light`` shines by. emissive (linear r, g, b) and double_sided are kept: every surface is drawn from
    both sides, and none gives light.
    """

    base_color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    base_color_texture: ColorTexture | None = None
    alpha_mode: AlphaMode = "OPAQUE"
    alpha_cutoff: float = 0.5
    emissive: Color = (0.0, 0.0, 0.0)
    metallic: float = 0.0
    roughness: float = 1.0
    double_sided: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        if len(self.base_color) != 4 or not all(0 <= value <= 1 for value in self.base_color):
            raise SceneError(f"material '{self.name}': base_color must be four numbers from 0 to 1, got {self.base_color}")
        if self.alpha_mode not in ("OPAQUE", "MASK", "BLEND"):
            raise SceneError(f"material '{self.name}': alpha_mode '{self.alpha_mode}'; must be OPAQUE, MASK or BLEND")
        if not math.isfinite(self.alpha_cutoff):
            raise SceneError(f"material '{self.name}': alpha_cutoff is {self.alpha_cutoff:g}; it must be finite")

    @property
    def cutoff(self) -> float | None:
        """Alpha below which there is no surface; None: there is one whatever alpha says."""
        return {"OPAQUE": None, "MASK": self.alpha_cutoff, "BLEND": SOLID_FROM}[self.alpha_mode]

    @property
    def color(self) -> Color:
        """``base_color`` without alpha, sRGB."""
        return srgb.encoded_rgb(self.base_color[:3])


def alpha_range(values: NDArray[np.uint8]) -> tuple[float, float]:
    """Return the smallest and largest of some alpha values, in 0..1."""
    return int(values.min(initial=255)) / 255, int(values.max(initial=0)) / 255
