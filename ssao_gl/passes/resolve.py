"""Several samples a pixel to one: means of what may be mixed, and one sample of what may not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..graph.declare import Pass, Texture
from ..graph.draws import Define, Fullscreen
from ..graph.names import BENT_NORMAL, COLOR, DEPTH, IMAGE, LABELS, SHADING_NORMAL, VISIBILITY

MEANS: Mapping[str, tuple[str, Mapping[str, Define]]] = {
    IMAGE: ("rgba8", {"SRGB": 1, "ALPHA": 1}),
    COLOR: ("rgba8", {"SRGB": 1}),
    VISIBILITY: ("r8", {}),
}
"""What is averaged: its format, and how. Colours in linear light, the image's by their alpha, which becomes coverage."""

PICKED: Mapping[str, tuple[str, str]] = {
    DEPTH: ("r32f", "z"),
    SHADING_NORMAL: ("rg16f", "normal"),
    BENT_NORMAL: ("rg16f", "bent"),
    LABELS: ("rgba32ui", "label"),
}
"""What the sample of median depth gives: a mean would be of no surface. Format, and its name in the shader."""


def resolved(resource: str) -> str:
    """Return the resource that holds one value a pixel of what ``resource`` holds for every sample."""
    return f"{resource}_resolved"


def resolve(resources: Sequence[str], samples: int) -> list[Pass]:
    """Return the passes that bring ``resources`` from ``samples`` a side of each pixel to one."""
    size = 1 / samples
    each = [_mean(name, samples) for name in resources if name in MEANS]
    picked = [name for name in resources if name in PICKED]
    if not picked:
        return each
    samplers, defines = {"u_z": DEPTH}, {**_grid(samples), "TARGETS": len(picked)}
    for place, name in enumerate(picked):
        short = PICKED[name][1]
        samplers |= {f"u_{short}": name}
        defines |= {short.upper(): place}
    draw = Fullscreen("resolve_median.frag", samplers, defines=defines)
    return [
        *each,
        Pass("resolve surface", "composite", draw, {resolved(name): Texture(PICKED[name][0], size) for name in picked}),
    ]


def _mean(name: str, samples: int) -> Pass:
    form, defines = MEANS[name]
    draw = Fullscreen("resolve_mean.frag", {"u_samples": name}, defines={**_grid(samples), **defines})
    return Pass(f"resolve {name}", "composite", draw, {resolved(name): Texture(form, 1 / samples)})


def _grid(samples: int) -> dict[str, Define]:
    return {"SIDE": samples, "SAMPLES": samples * samples}
