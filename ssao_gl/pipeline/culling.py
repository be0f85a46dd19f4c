"""Which culling rules a plan follows: how it finds what need not be shaded."""

from __future__ import annotations

from dataclasses import dataclass

from ..graph.declare import DepthTest, Pass
from ..passes import culling, occlusion
from ..scene.projection import Size
from .settings import Settings, small_scale


@dataclass(frozen=True, slots=True)
class CullingPlan:
    """How a plan finds what need not be shaded.

    background: it is left out. cover: the depth test at full size that does so, None without. blocks: passes that find open
    blocks; none when nobody looks for them, for the reason ``why``.
    """

    background: bool
    cover: DepthTest | None
    blocks: tuple[Pass, ...]
    why: str


def plan_culling(
    settings: Settings, cover: DepthTest | None, size: Size, triangles: int | None, *, flat_normals: bool, bent: bool = False
) -> CullingPlan:
    """What is left out. ``triangles`` of a scene that surrounds the camera; ``flat_normals``: normals are those that depth shows;
    ``bent``: bent normals are drawn too."""
    method, keep = settings.method, settings.keep
    background = "background" not in keep
    cover = cover if background else None
    if bent and settings.blur is None and small_scale(settings) == 1:
        return CullingPlan(background, cover, (), "bent normals without a filter are drawn everywhere")
    if getattr(method, "adaptive", False) and "adaptive" not in keep:
        return CullingPlan(
            background,
            cover,
            (occlusion.probe_blocks(method, culling.PROBE, culling.BLOCK), culling.open_blocks_by_probe()),
            "",
        )
    taps = getattr(method, "slices", 1) * getattr(method, "steps", 0) / small_scale(settings) ** 2
    why = ""
    if not getattr(method, "open_is_exact", False):
        why = f"{method.name} may darken what nothing stands above"
    elif "open" in keep:
        why = "switched off"
    elif not flat_normals:
        why = "normals are not those of the surface that depth shows"
    elif taps < culling.STEPS:
        why = f"{taps:g} taps a pixel and side cost less than looking for blocks to leave out"
    elif triangles is None:
        why = "the scene does not surround the camera (or is not known): most of what is open is background"
    elif triangles * culling.TRIANGLE > size[0] * size[1]:
        why = f"with {triangles:,} triangles in {size[0]}x{size[1]} pixels few blocks are flat"
    return CullingPlan(
        background, cover, () if why else (culling.bound_blocks(), culling.open_blocks(method.radius, method.max_radius)), why
    )  # type: ignore[attr-defined]
