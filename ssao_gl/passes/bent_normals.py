"""Bent normals: a second target beside visibility, drawn with it and filtered by the same weights. Without them nothing is more."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..glsl.preprocess import Define
from ..graph.declare import Texture

BENT = "bent"
"""The mean open direction, encoded as normals are."""

FINAL = ("visibility", "upsampled")
"""Visibilities of full size that no filter follows."""


@dataclass(frozen=True, slots=True)
class ExtraSignal:
    """What a pass has more."""

    writes: Mapping[str, Texture] = field(default_factory=dict)
    defines: Mapping[str, Define] = field(default_factory=dict)
    samplers: Mapping[str, str] = field(default_factory=dict)


def extra_signal(wanted: bool, source: str | None, result: str, scale: int = 1) -> ExtraSignal:
    """Of the pass from visibility ``source`` (None: the method's own) to ``result``; see ``shaders/lib/sum.glsl``."""
    if not wanted:
        return ExtraSignal()
    last = result in FINAL
    writes = {BENT: Texture("rg16f")} if last else {_lost(result): Texture("rgba16f", 1 / scale)}
    return ExtraSignal(writes, {"BENT": 2 if last else 1}, {"u_lost": _lost(source)} if source else {})


def _lost(visibility: str) -> str:
    return f"{visibility} lost"
