"""Signals beside visibility: bent normals, and light from what hides. Second and third targets, drawn with it and filtered by the same weights; without them nothing is more."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from ..graph.declare import Texture
from ..graph.draws import Define
from ..graph.names import BENT_NORMAL, GAINED, VISIBILITY, VISIBILITY_UPSAMPLED

FINAL = (VISIBILITY, VISIBILITY_UPSAMPLED)
"""Visibilities of full size that no filter follows."""
SIGNALS: Mapping[str, tuple[str, str, str]] = {
    BENT_NORMAL: ("BENT", "u_lost", "rg16f"),
    GAINED: ("BOUNCE", "u_gained", "rgba16f"),
}
"""Signal -> define, sampler of what is filtered, format at the end. See ``shaders/lib/accumulate.glsl``."""


@dataclass(frozen=True, slots=True)
class ExtraSignal:
    """What a pass writes, defines and samples more."""

    writes: Mapping[str, Texture] = field(default_factory=dict)
    defines: Mapping[str, Define] = field(default_factory=dict)
    samplers: Mapping[str, str] = field(default_factory=dict)


def extra_signals(wanted: Collection[str], source: str | None, result: str, scale: int = 1) -> ExtraSignal:
    """Return what the pass from visibility ``source`` to ``result`` has more where signals are ``wanted``.

    ``source`` None: the method's own pass.
    """
    last = result in FINAL
    writes: dict[str, Texture] = {}
    defines: dict[str, Define] = {}
    samplers: dict[str, str] = {}
    for signal, (define, sampler, form) in SIGNALS.items():
        if signal in wanted:
            writes |= {signal: Texture(form)} if last else {made_of(result, signal): Texture("rgba16f", 1 / scale)}
            defines[define] = 2 if last else 1
            samplers |= {sampler: made_of(source, signal)} if source else {}
    return ExtraSignal(writes, defines, samplers)


def made_of(visibility: str, signal: str) -> str:
    """Return the resource that holds what a signal is made of, beside a visibility."""
    return f"{visibility}_{signal}"
