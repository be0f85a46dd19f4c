"""Bent normals: a second target beside visibility, drawn with it and filtered by the same weights. Without them nothing is more."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..graph.declare import Texture
from ..graph.draws import Define
from ..graph.names import BENT_NORMAL, VISIBILITY, VISIBILITY_UPSAMPLED

FINAL = (VISIBILITY, VISIBILITY_UPSAMPLED)
"""Visibilities of full size that no filter follows."""


@dataclass(frozen=True, slots=True)
class ExtraSignal:
    """What a pass writes, defines and samples more."""

    writes: Mapping[str, Texture] = field(default_factory=dict)
    defines: Mapping[str, Define] = field(default_factory=dict)
    samplers: Mapping[str, str] = field(default_factory=dict)


def extra_signal(wanted: bool, source: str | None, result: str, scale: int = 1) -> ExtraSignal:
    """Return what the pass from visibility ``source`` to ``result`` has more where bent normals are wanted.

    ``source`` None: the method's own pass. See ``shaders/lib/accumulate.glsl``.
    """
    if not wanted:
        return ExtraSignal()
    last = result in FINAL
    writes = {BENT_NORMAL: Texture("rg16f")} if last else {occluded_direction(result): Texture("rgba16f", 1 / scale)}
    return ExtraSignal(writes, {"BENT": 2 if last else 1}, {"u_lost": occluded_direction(source)} if source else {})


def occluded_direction(visibility: str) -> str:
    """Return the resource that holds the mean occluded direction beside a visibility."""
    return f"{visibility}_occluded"
