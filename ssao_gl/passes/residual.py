"""Residual rays: what a few rays see more than the screen, spread by a wide joint filter and added to the screen's visibility.

With A the screen's visibility, D = rays - A where there are rays, n their number and N(.) the filter's weighted sum over the
neighbours on the same surface, a pixel gets ``A + (n D + own F) / (n + own)`` with ``F = N(n D) / (N(n) + least)``. Both are
best linear guesses from noisy means (Efron & Morris 1973): ``least`` is the variance of a ray over that of the screen's error,
``own`` is it over the variance of that error among neighbours. So nothing is added where there are no rays, noise stays below the
error that it mends, and with ever more rays the result is theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..graph.declare import DepthTest, Pass, Texture
from ..graph.draws import Define, FloatTable, Fullscreen, HostWork, Uniform, ViewValue
from ..graph.names import DEPTH, NORMAL, RAYS, RESIDUAL, RESIDUAL_X, RESIDUAL_Y, VISIBILITY, VISIBILITY_SCREEN
from .denoise import gaussian

BLOCK_SIDE = 2
"""Pixels along each side of a block, whose rays are one texel of the filter."""

TRACE_RAYS = "rays"
"""Name of the host's work."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """How residuals are spread. radius: half width, pixels. tolerance: off the tangent plane, pixels. least, own: see above, rays."""

    radius: int
    sigma: float
    tolerance: float
    least: float
    own: float


def residual_rays(share: float, radius: float, falloff: str, spread: Spread, mask: DepthTest | None) -> list[Pass]:
    """Return the passes from the screen's visibility to the corrected one; ``share``: rays a pixel, ``radius``: their reach, scene units."""
    work = HostWork(TRACE_RAYS, {"depth": DEPTH, "normal": NORMAL}, {"share": share, "radius": radius, "falloff": falloff})
    return [
        Pass("rays", "occlusion", work, {RAYS: Texture("r32f")}, clear=(0.0,) * 4),
        _gathered(spread),
        _spread_along(0, RESIDUAL, RESIDUAL_X, spread),
        _spread_along(1, RESIDUAL_X, RESIDUAL_Y, spread),
        _added(spread, mask),
    ]


def _gathered(spread: Spread) -> Pass:
    """Gather the residuals of each block on the surface of its first ray."""
    samplers = {"u_rays": RAYS, "u_screen": VISIBILITY_SCREEN, "u_z": DEPTH, "u_normal": NORMAL}
    uniforms: dict[str, Uniform] = {"u_per_pixel": ViewValue("pixel", spread.tolerance, inverse=True)}
    draw = Fullscreen("residual_gather.frag", samplers, uniforms)
    return Pass("gather residuals", "denoise", draw, {RESIDUAL: _texels()}, clear=(0.0,) * 4)


def _spread_along(axis: int, source: str, result: str, spread: Spread) -> Pass:
    """Filter along an axis; sums stay sums."""
    radius = max(1, round(spread.radius / BLOCK_SIDE))
    uniforms: dict[str, Uniform] = {
        "u_next": ViewValue("target_texel", axis=axis),
        "u_step": ViewValue("target_step", axis=axis),
        "u_weights": FloatTable.of(gaussian(radius, spread.sigma / BLOCK_SIDE)),
        "u_per_pixel": ViewValue("pixel", spread.tolerance, inverse=True),
    }
    defines: dict[str, Define] = {"RADIUS": radius}
    draw = Fullscreen("residual_filter.frag", {"u_residual": source}, uniforms, defines=defines)
    return Pass(f"residual filter {'xy'[axis]}", "denoise", draw, {result: _texels()}, clear=(0.0,) * 4)


def _added(spread: Spread, mask: DepthTest | None) -> Pass:
    """Add what was spread, and each pixel's own rays, to the screen's visibility."""
    samplers = {"u_residual": RESIDUAL_Y, "u_rays": RAYS, "u_screen": VISIBILITY_SCREEN, "u_z": DEPTH, "u_normal": NORMAL}
    uniforms: dict[str, Uniform] = {
        "u_small_texel": ViewValue("resource_size", inverse=True, resource=RESIDUAL_Y),
        "u_per_pixel": ViewValue("pixel", spread.tolerance, inverse=True),
        "u_least": spread.least,
        "u_own": spread.own,
    }
    draw = Fullscreen("residual_add.frag", samplers, uniforms)
    return Pass("residual filter", "denoise", draw, {VISIBILITY: Texture("r8")}, test=mask, clear=(1.0,) * 4)


def _texels() -> Texture:
    return Texture("rgba32f", 1 / BLOCK_SIDE)
