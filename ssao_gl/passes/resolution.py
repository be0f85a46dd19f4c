"""Occlusion at a smaller size: shrink depth and normals, bring visibility back to full size, mend what that misses."""

from __future__ import annotations

from ..gl.executor import Stage
from ..graph.declare import DepthTest, Pass, Texture
from . import culling
from .bent_normals import extra_signal

REFINE_MASK = "missed"
"""Depth buffer of the image: 0 where no small texel knows the pixel's surface."""

EDGE = 30.0
"""Depths that differ by more, in the size of a pixel, are of two surfaces, which take turns. Elsewhere the same pixel is kept
everywhere: an even grid is what interpolation is exact on."""


def downsample(scale: int, *, open_blocks: bool) -> Pass:
    """``small z`` and ``small normal``: one pixel of each ``scale`` x ``scale``, and which of them there is to shade."""
    defines = {"SCALE": scale, "PIXELS": scale * scale, "TARGETS": 2}
    samplers = {"u_z": "z", "u_normal": "normal"}
    writes = {"small z": Texture("r32f", 1 / scale), "small normal": Texture("rg16f", 1 / scale)}
    if open_blocks:
        defines |= {"OPEN": 1, "PACKED": 1, "TARGETS": 3}
        samplers |= {"u_open": culling.OPEN}
        writes |= {culling.UNTOUCHED: Texture("r32f", 1 / scale)}

    def draw(stage: Stage) -> None:
        uniforms = {"u_edge": EDGE * stage.view.pixel, **(culling.per_block(stage) if open_blocks else {})}
        stage.fullscreen("shrink.frag", uniforms, samplers, defines=defines)

    return Pass("shrink", tuple(samplers.values()), writes, draw, depth=culling.SHADE_MASK, clear=(0.0,) * 4)


def upsample(source: str, scale: int, tolerance: float, cover: DepthTest | None, least: float, *, bent: bool = False) -> Pass:
    """``visibility`` from ``source`` (packed, small); texels count in full up to ``tolerance`` of theirs off the tangent plane.

    ``least`` above 0: ``upsampled`` instead, with a mask of the pixels whose texels together weigh less.
    """
    result = "upsampled" if least else "visibility"
    more = extra_signal(bent, source, result)
    defines = {"PACKED": 1, **({"REFINE": 1} if least else {}), **more.defines}
    samplers = {"u_packed": source, "u_z": "z", "u_normal": "normal", "u_small_normal": "small normal", **more.samplers}

    def draw(stage: Stage) -> None:
        w, h = Texture("r32f", 1 / scale).size(stage.view.size)
        uniforms = {
            "u_small_texel": (1 / w, 1 / h),
            "u_small_scale": float(scale),
            "u_per_pixel": 1 / (tolerance * scale * stage.view.pixel),
            **({"u_least": least} if least else {}),
        }
        stage.fullscreen("upsample.frag", uniforms, samplers, defines=defines)

    reads, writes = tuple(samplers.values()), {result: Texture("r8"), **more.writes}
    if least:  # a pass that writes depth cannot be tested against another
        return Pass("upsample", reads, writes, draw, depth=REFINE_MASK, clear=(1.0,) * 4)
    return Pass("upsample", reads, writes, draw, test=cover, clear=(1.0,) * 4)
