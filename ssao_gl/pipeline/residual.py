"""How residual rays are set up for a base: data, measured, in one place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..errors import SettingsError
from ..graph.declare import DepthTest, Pass
from ..graph.names import VISIBILITY, VISIBILITY_SCREEN
from ..passes.residual import Spread, residual_rays
from ..sampling.falloff import Falloff
from ..settings import as_table
from .settings import Settings

SPREADS = {
    1: Spread(radius=8, sigma=6.0, tolerance=1.0, least=30.0, own=64.0),
    2: Spread(radius=8, sigma=6.0, tolerance=1.0, least=60.0, own=64.0),
}
"""Layers of depth that the base knows -> how residuals of it are spread."""


def corrected(settings: Settings, screen: Sequence[Pass], mask: DepthTest | None) -> list[Pass]:
    """Return the passes of the screen's visibility, and behind them those that correct it by the rays that are asked for.

    Raises SettingsError for methods whose radius is no length.
    """
    if not settings.rays:
        return list(screen)
    method = settings.method
    if method.traits.radius_unit != "scene units" or method.radius is None:
        raise SettingsError(
            f"rays: {method.name} has a radius in {method.traits.radius_unit}, and rays need one in scene units; use bitmask"
        )
    falloff = as_table(method).get("falloff")
    falloff = falloff if falloff in tuple(Falloff) else Falloff.HARD
    spread = SPREADS[2 if "second_layer" in method.traits.inputs else 1]
    return [*map(_of_the_screen, screen), *residual_rays(settings.rays, float(method.radius), str(falloff), spread, mask)]


def check_no_rays(settings: Settings, who: str) -> None:
    """Raise SettingsError where rays are asked for and there is no scene to trace."""
    if settings.rays:
        raise SettingsError(
            f"rays={settings.rays:g}: {who} has a depth buffer and no scene to trace; use render, or leave it out"
        )


def _of_the_screen(task: Pass) -> Pass:
    """Return a pass with visibility under the name of what the screen knows."""
    return replace(
        task, writes={VISIBILITY_SCREEN if name == VISIBILITY else name: target for name, target in task.writes.items()}
    )
