"""Which culling rules a plan follows: how it finds what need not be shaded."""

from __future__ import annotations

from dataclasses import dataclass

from ..graph.declare import DepthTest, Pass
from ..graph.names import BLOCK_PROBE
from ..passes.culling import BLOCK, TAPS, TRIANGLE, bound_blocks, open_blocks, open_blocks_by_probe
from ..passes.occlusion import probe_blocks
from ..scene.projection import Size
from .exclusion import no_casters
from .settings import Settings, drawn_scale


@dataclass(frozen=True, slots=True)
class CullingPlan:
    """How a plan finds what need not be shaded.

    background: it is left out. mask: the depth test at full size that does so, None without. blocks: passes that find open
    blocks; none when nobody looks for them, for the reason ``why``.
    """

    background: bool
    mask: DepthTest | None
    blocks: tuple[Pass, ...]
    why: str


def plan_culling(
    settings: Settings,
    mask: DepthTest | None,
    size: Size,
    triangles: int | None,
    *,
    flat_normals: bool,
    signals: bool = False,
) -> CullingPlan:
    """Decide which rules are in force.

    ``triangles`` of a scene that surrounds the camera; ``flat_normals``: normals are those that depth shows; ``signals``: bent
    normals or bounces are drawn too.
    """
    background = "background" not in settings.keep
    mask = mask if background else None
    if signals and settings.blur is None and drawn_scale(settings) == 1:
        return CullingPlan(background, mask, (), "bent normals and bounces without a filter are drawn everywhere")
    method = settings.method
    if method.traits.probe and "adaptive" not in settings.keep:
        return CullingPlan(background, mask, (probe_blocks(method, BLOCK_PROBE, BLOCK), open_blocks_by_probe()), "")
    why = _why_no_open_blocks(settings, size, triangles, flat_normals=flat_normals)
    if why:
        return CullingPlan(background, mask, (), why)
    farthest = method.radius * method.traits.occluder_reach
    reach = method.traits.max_reach or float(max(size))
    return CullingPlan(background, mask, (bound_blocks(), open_blocks(method.radius, farthest, reach)), "")


def _why_no_open_blocks(settings: Settings, size: Size, triangles: int | None, *, flat_normals: bool) -> str:
    """Return why nobody looks for open blocks; empty where somebody does."""
    traits = settings.method.traits
    taps = traits.taps / drawn_scale(settings) ** 2
    if not traits.exactly_open:
        return f"{settings.method.name} may darken what nothing stands above"
    if no_casters(settings):
        return "what casts no occlusion may hide what does"
    if "open" in settings.keep:
        return "switched off"
    if not flat_normals:
        return "normals are not those of the surface that depth shows"
    if taps < TAPS:
        return f"{taps:g} taps a pixel and side cost less than looking for blocks to leave out"
    if triangles is None:
        return "the scene does not surround the camera (or is not known): most of what is open is background"
    if triangles * TRIANGLE > size[0] * size[1]:
        return f"with {triangles:,} triangles in {size[0]}x{size[1]} pixels few blocks are flat"
    return ""
