"""What decides a baking but the scene."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import ClassVar

from ..errors import SettingsError
from ..sampling.falloff import Falloff
from ..settings import setting, validate

BY = ("rays", "elements")
KERNELS = ("disk", "gems")
SIDES = ("auto", "front", "both")
UNWRAP = ("auto", "always", "never")
LONGEST = 1024
"""Rays of a place that are stratified together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Baking:
    """Settings of :func:`ssao_gl.bake` that have to do with what is measured, and how."""

    name: ClassVar[str] = "bake"
    max_stderr: ClassVar[None] = None

    radius: float | None = setting(None, "reach of occlusion; none: 3 % of the scene's size", unit="scene units", above=0)
    falloff: str = setting(Falloff.HARD.value, "how a blocker counts with distance", choices=tuple(f.value for f in Falloff))
    spp: int = setting(64, "rays a vertex or texel, rounded up to a power of two", low=1, high=1 << 20)
    points: int = setting(16, "points of a vertex's fan that share its rays", low=1, high=1 << 12)
    sides: str = setting(
        "auto",
        "side of the surface that counts; both: the more open one at each vertex or texel; auto: both where the material is"
        " double-sided, front elsewhere",
        choices=SIDES,
    )
    seed: int = setting(0, "of points and directions", low=0, high=2**31 - 1)

    by: str = setting("rays", "what measures: rays, or disks that stand for the scene's triangles", choices=BY)
    passes: int = setting(4, "of elements, against shadows counted twice; the last two are averaged", low=1, high=16)
    indirect: bool = setting(False, "add the light that elements send each other, in their colours, to the colours of vertices")
    kernel: str = setting(
        "disk", "what a disk takes; gems: the formula of GPU Gems 2, darker far off its axis", choices=KERNELS
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.by == "elements" and self.falloff != Falloff.HARD:
            raise SettingsError(f"falloff '{self.falloff}': elements know a hard radius only; take hard, or bake by rays")
        if self.indirect and self.by != "elements":
            raise SettingsError("indirect: is the light that elements send; add --by elements (by='elements')")

    def with_radius(self, radius: float) -> Baking:
        """Return these settings with an automatic radius settled to ``radius`` scene units."""
        return self if self.radius is not None else dataclasses.replace(self, radius=radius)

    @property
    def batches(self) -> tuple[int, int]:
        """(rays a place in a batch, batches): one batch as long as it may be, for its rays are stratified together."""
        length = min(1 << (self.spp - 1).bit_length(), LONGEST)
        return length, -(-self.spp // length)


@dataclass(frozen=True, slots=True, kw_only=True)
class Vertices:
    """Visibility goes to an attribute of vertices."""

    name: ClassVar[str] = "vertices"

    attribute: str = setting("COLOR_0", "COLOR_0, whose colours are multiplied, or a name that begins with _")

    def __post_init__(self) -> None:
        validate(self)
        if self.attribute != "COLOR_0" and not re.fullmatch(r"_[A-Z0-9_]+", self.attribute):
            raise SettingsError(
                f"attribute '{self.attribute}': must be COLOR_0, or begin with _ and have capitals and digits, like _AO"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class OcclusionTexture:
    """Visibility goes to occlusion textures."""

    name: ClassVar[str] = "texture"

    size: int = setting(1024, "width and height of each texture", unit="texels", low=16, high=4096)
    padding: int = setting(4, "between charts of an atlas that is made", unit="texels", low=0, high=64)
    unwrap: str = setting(
        "auto", "make texture coordinates; auto: where there are none in 0..1 that do not overlap", choices=UNWRAP
    )

    def __post_init__(self) -> None:
        validate(self)
