"""How residual rays are set up for a base: data, measured, in one place."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..errors import SettingsError
from ..graph.declare import DepthTest, Pass
from ..graph.names import VISIBILITY, VISIBILITY_SCREEN
from ..passes.residual import BLOCK_SIDE, Spread, residual_rays
from ..sampling.falloff import Falloff
from ..settings import as_table
from .settings import Settings

SPREADS = (
    (1 / 8, Spread(radius=16, sigma=12.0, tolerance=1.0, least=8.0, own=64.0)),
    (1.5, Spread(radius=10, sigma=8.0, tolerance=1.0, least=8.0, own=64.0)),
    (6.0, Spread(radius=6, sigma=4.0, tolerance=1.0, least=8.0, own=32.0)),
    (math.inf, Spread(radius=4, sigma=2.5, tolerance=1.0, least=8.0, own=32.0)),
)
"""Most rays a pixel -> how their residuals are spread; the more rays, the less far.

Measured on six views at 1280x720 (sponza:atrium, hotel_room:sofa, featuretype:iso, nefertiti:threequarter, carriage:wheel,
bridge_garden:bridge; RMSE against 64 rays, their noise subtracted). ``medium`` with 1/4 ray under ``least`` 4, 8, 15, 30, 60: .0431, .0436,
.0454, .0489, .0533 (radius 8); under (radius, sigma) (8, 6), (10, 6), (10, 8): .0436, .0431, .0426. ``ultra`` with 1/4 under
``least`` 8, 16, 32: .0356, .0359, .0374; with 1 under 4, 8, 15: .0293, .0295, .0301. The share of the residual that is added,
``n / (n + least)`` for n rays within reach, so follows the number of rays by itself; a better base wants a larger ``least``, though all
of these want about the same.
On three of these (hotel_room, featuretype, carriage): ``medium`` with 1/16 under (10, 8), (16, 12): .0585, .0561; ``high`` with 2 under (10, 8),
(6, 4): .0304, .0290; with 4 under (10, 8) and ``own`` 64, 32, 16: .0285, .0285, .0303, under (6, 4) and 32: .0269; with 12 under (6, 4) and 32,
(4, 2.5) and 32, 16: .0230, .0225, .0252.
"""


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
    share = float(settings.rays) / settings.supersample**2  # of the frame's pixels
    falloff = as_table(method).get("falloff")
    falloff = falloff if falloff in tuple(Falloff) else Falloff.HARD
    return [
        *(task.renamed(VISIBILITY, VISIBILITY_SCREEN) for task in screen),
        *residual_rays(share, float(method.radius), str(falloff), _spread(share), mask),
    ]


def residual_reach(settings: Settings) -> int:
    """Return how far from a pixel the rays may start that correct it, pixels."""
    return _spread(settings.rays).radius + 2 * BLOCK_SIDE if settings.rays else 0


def check_no_scene(settings: Settings, who: str) -> None:
    """Raise SettingsError where something is asked for that needs a scene: rays, more samples a pixel, names of things."""
    if settings.rays:
        raise SettingsError(
            f"rays={settings.rays:g}: {who} has a depth buffer and no scene to trace; use render, or leave it out"
        )
    if settings.supersample > 1:
        raise SettingsError(
            f"supersample={settings.supersample}: {who} has one sample a pixel; use render, or give larger images"
        )
    if settings.exclude:
        raise SettingsError(f"exclude: {who} knows no names of things; use render, or leave it out")


def _spread(share: float) -> Spread:
    """Return how residuals of so many rays a pixel are spread."""
    return next(spread for most, spread in SPREADS if share <= most)
