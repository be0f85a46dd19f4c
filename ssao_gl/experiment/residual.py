"""Screen space and rays together: estimators that correct a screen-space method by a few rays a pixel."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..errors import SettingsError, near_miss
from ..pipeline.presets import as_rays
from ..truth.rays import tree_bytes
from .estimators import Drawn, Preparation, Prepared, ScreenSpace
from .view_setup import ViewSetup


@dataclass(frozen=True, slots=True)
class ResidualRays:
    """A screen-space method whose residual ``share`` rays a pixel tell. Its passes have the rays among them."""

    base: ScreenSpace
    share: float
    most_rounds = 3
    realtime = False
    pictured = True

    @property
    def family(self) -> str:
        """What joins those of a method."""
        return f"{self.base.family} + rays"

    @property
    def preset(self) -> str:
        """The effort of both."""
        return f"{self.base.preset} + {_fraction(self.share)}"

    @property
    def label(self) -> str:
        """What tables and plots call it."""
        return f"{self.base.label} + rays {_fraction(self.share)}"

    def table(self) -> Mapping[str, Any]:
        """Return its settings."""
        return {**self.base.table(), "rays": self.share}

    def prepare(self, setup: ViewSetup) -> Prepared:
        """Return it ready for a view: with the scene's tree. The G-buffer is each frame's own."""
        settings = setup.settled(dataclasses.replace(self.base.settings, rays=self.share))
        setup.time(settings)
        return Drawn(setup, settings, Preparation(setup.tree_ms, tree_bytes(setup.scene)))


def residual_rays_upon(methods: Sequence[ScreenSpace], asked: Iterable[str]) -> list[ResidualRays]:
    """Return the estimators of texts like ``1/4`` (upon all methods), or ``medium+1/4`` (upon those under that preset).

    Raises SettingsError for no number, for rays below or of 0, and for a preset that is not there.
    """
    found, presets = [], list(dict.fromkeys(one.preset for one in methods))
    for text in asked:
        preset, _, number = text.rpartition("+")
        share = as_rays(number)
        if not share > 0:
            raise SettingsError(f"--rays {text}: must be above 0")
        if preset and preset.strip() not in presets:
            raise SettingsError(
                f"--rays {text}: no such preset here; there are {', '.join(presets)}.{near_miss(preset, presets)}"
            )
        found += [ResidualRays(one, share) for one in methods if not preset or one.preset == preset.strip()]
    return found


def _fraction(share: float) -> str:
    """Return a share as people write it: 1/4, 2, 0.3."""
    near = Fraction(share).limit_denominator(64)
    return str(near) if float(near) == share else f"{share:g}"
