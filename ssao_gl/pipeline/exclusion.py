"""Things that receive no occlusion, and things that cast none: which these are, and the passes that make it so."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import SettingsError
from ..graph.declare import Pass
from ..graph.names import CASTER_DEPTH, DEPTH
from ..passes.exclude import among_casters, can_leave_out_casters, caster_depth, open_excluded, receiver_depth
from ..passes.gbuffer import layer_behind
from .settings import Settings

CASTS = ":casts"


def no_receivers(settings: Settings) -> tuple[str, ...]:
    """Return the names of what receives no occlusion."""
    return tuple(name for name in settings.exclude if not name.endswith(CASTS))


def no_casters(settings: Settings) -> tuple[str, ...]:
    """Return the names of what casts no occlusion."""
    return tuple(name.removesuffix(CASTS) for name in settings.exclude if name.endswith(CASTS))


def layers(settings: Settings) -> list[Pass]:
    """Return the passes that draw the scene's depth again: behind the first surface, and without what is excluded."""
    traits, receivers, casters = settings.method.traits, no_receivers(settings), no_casters(settings)
    gap, front = traits.layer_gap * (settings.method.radius or 0.0), CASTER_DEPTH if casters else DEPTH
    return [
        *([caster_depth(casters)] if casters else []),
        *([receiver_depth(receivers)] if receivers else []),
        layer_behind(gap, traits.layer_scale, front=front, without=casters),
    ]


def excluded(settings: Settings, screen: Sequence[Pass]) -> list[Pass]:
    """Return the passes of visibility as they are with what is excluded. Raises SettingsError where it cannot be."""
    passes = list(screen)
    if settings.exclude and settings.rays:
        raise SettingsError("exclude: rays meet all things alike; leave out --rays, or --exclude")
    if no_casters(settings):
        if not can_leave_out_casters(settings.method):
            raise SettingsError(f"exclude NAME{CASTS}: {settings.method.name} looks at what is seen alone; use bitmask")
        passes = [among_casters(task) for task in passes]
    return open_excluded(passes) if no_receivers(settings) else passes
