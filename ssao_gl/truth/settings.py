"""What decides a traced picture but the scene, the camera and the size."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

from ..sampling.falloff import Falloff
from ..settings import setting, validate

NORMALS = ("geometric", "shading")
SPP, MOST_SPP = 1024, 1 << 16
ROUND = 64
"""Rays per pixel in a batch when ``max_stderr`` decides how many there are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracing:
    """Settings of :func:`ssao_gl.truth.trace`."""

    name: ClassVar[str] = "truth"

    radius: float | None = setting(None, "reach of occlusion; none: from the camera or the scene", unit="scene units", above=0)
    falloff: str = setting(Falloff.HARD.value, "how a blocker counts with distance", choices=tuple(f.value for f in Falloff))
    normals: str = setting(
        "geometric", "hemisphere about the triangle's own or the interpolated vertex normal", choices=NORMALS
    )
    spp: int | None = setting(
        None,
        f"rays a pixel, rounded up to whole batches; none: {SPP}, or {MOST_SPP} at most with max_stderr",
        low=1,
        high=1 << 24,
    )
    max_stderr: float | None = setting(
        None, "stop when the pixels' standard errors are below this in the mean square", above=0, high=0.5
    )
    seed: int = setting(0, "of the directions", low=0, high=2**31 - 1)

    def __post_init__(self) -> None:
        validate(self)

    def with_radius(self, radius: float) -> Tracing:
        """Return these settings with an automatic radius settled to ``radius`` scene units."""
        return self if self.radius is not None else dataclasses.replace(self, radius=radius)

    @property
    def batches(self) -> tuple[int, int]:
        """(rays a pixel in a batch, most batches).

        Batches are scrambled independently, so their spread gives the standard error; within one, rays are stratified.
        So they shall be few and long: about eight, a power of two long as Sobol points want it. With ``max_stderr`` the
        number is not known beforehand, and all have ``ROUND`` rays.
        """
        if self.max_stderr is not None:
            return ROUND, -(-(self.spp or MOST_SPP) // ROUND)
        spp = self.spp or SPP
        most = max(spp // min(max(spp // 8, 2), 8), 1)
        length = 1 << (most.bit_length() - 1)
        return length, -(-spp // length)
