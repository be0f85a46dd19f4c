"""The fitted track: scalars found on one set of scenes, and measured, frozen, on all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..errors import SettingsError
from ..io.journal import Journal
from .estimators import ScreenSpace
from .fit import FACTORS, Levels, Scalars, fit
from .sweep import Sweep
from .view_setup import ViewSetup
from .views import MeasuredView

Fits = Mapping[str, tuple[Scalars, float]]
"""label -> (scalars, mean RMSE over the views they were fitted on)."""


def gather_levels(setup: ViewSetup, variant: ScreenSpace) -> dict[str, list[list[float]]]:
    """Radius factor, as text, -> sums over levels of visibility; factors that a method refuses are left out."""
    found = {}
    for factor in FACTORS:
        try:
            visibility = setup.draw(setup.settled(variant.settings, factor))
        except SettingsError:
            continue
        found[f"{factor:g}"] = Levels.of(visibility, setup.truth.visibility, setup.depth > 0).saved()
    return found


def fits(sweep: Sweep, journal: Journal) -> Fits:
    """Of all variants that took part in every view that is fitted on."""
    wanted = [view.name for view in fitting_views(sweep)]
    found = {}
    for variant in sweep.methods:
        rows = [journal.find("levels", view, variant.label) for view in wanted]
        tried = _common([row["levels"] for row in rows if row])
        if tried and all(rows):
            found[variant.label] = fit(tried)
    return found


def fitting_views(sweep: Sweep) -> list[MeasuredView]:
    """Return views that scalars are fitted on: those of the fitting scenes, at the first size."""
    first = sweep.views[0].size
    return [view for view in sweep.views if view.scene in sweep.fit and view.size == first]


def _common(levels: Sequence[dict[str, list[list[float]]]]) -> dict[float, list[Levels]]:
    """Radius factor -> Levels of every view, of the factors that all views have."""
    if not levels:
        return {}
    return {
        float(factor): [Levels.loaded(view[factor]) for view in levels]
        for factor in levels[0]
        if all(factor in view for view in levels)
    }
