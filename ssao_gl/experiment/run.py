"""Measures everything a report is asked for, view by view; what the journal has already is left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ..io.journal import Journal
from ..render.renderer import Renderer
from . import scaling
from .fit_track import fits
from .steps import WorkStep, WorkSteps, shown_views
from .sweep import Sweep, SweepProgress
from .view_setup import ViewSetup
from .views import by_scene

MOST_PICTURES = 300
"""Pairs of small pictures on the page, at most: they bound its size."""


class Run:
    """One run over a sweep: ``Run(...).measure()``."""

    def __init__(
        self, sweep: Sweep, renderer: Renderer, journal: Journal, folder: Path, cache: Path | None, progress: SweepProgress
    ) -> None:
        self.sweep, self.renderer, self.journal = sweep, renderer, journal
        self.cache, self.progress = cache, progress
        self._steps = WorkSteps(sweep, journal, folder, shown_views(sweep, MOST_PICTURES))
        self._done = self._total = 0.0

    def measure(self) -> None:
        """All steps. Whatever ends it, finished rows are in the journal."""
        self._work([step for view in self.sweep.views for step in self._steps.unfitted(view)], self._ahead())
        found = {label: scalars for label, (scalars, _) in fits(self.sweep, self.journal).items()}
        steps = [step for view in self.sweep.views for step in self._steps.fitted(view, found)]
        self._work(steps + (self._scaling() if self.sweep.scaling else []), 0.0)

    def _ahead(self) -> float:
        """Cost of the fitted track, as far as it can be told before the fits are."""
        found = {label: scalars for label, (scalars, _) in fits(self.sweep, self.journal).items()}
        every = [(view, variant) for view in self.sweep.views for variant in self.sweep.methods if self.sweep.fit]
        return sum(self._steps.cost(view) for view, variant in every if not self._steps.has_fitted(view, variant, found))

    def _work(self, steps: Sequence[WorkStep], ahead: float) -> None:
        """Do the steps; ``ahead`` is the cost of what comes after them."""
        self._total = self._done + sum(step.cost for step in steps) + ahead
        for scene, views in by_scene([step.view for step in steps]):
            for view in dict.fromkeys(views):
                setup = ViewSetup(self.renderer, scene, view.camera, view.size, self.sweep.tracing, self.cache)
                for step in steps:
                    if step.view is view:
                        self._step(step, setup)

    def _step(self, step: WorkStep, setup: ViewSetup) -> None:
        began, title = self._done, f"{step.view.scene}:{step.view.camera.name} {step.title}"
        tell: Callable[[float], None] = lambda share: self.progress(title, began + step.cost * min(share, 1.0), self._total)  # noqa: E731
        tell(0.0)
        step.work(setup, tell)
        self._done = began + step.cost
        self.progress(title, self._done, self._total)

    def _scaling(self) -> list[WorkStep]:
        view, find = self.sweep.views[0], self.journal.find
        trials = scaling.trials(self.sweep, view)
        missing = [one for one in trials if not find("scaling", view.name, one.method, one.at)]

        def work(setup: ViewSetup, tell: Callable[[float], None]) -> None:
            groups = scaling.together(missing)
            for number, some in enumerate(groups):
                for one, values in zip(some, scaling.measure_scaling(setup, some, self.sweep.rounds), strict=True):
                    self.journal.add("scaling", view.name, one.method, one.at, **values)
                tell((number + 1) / len(groups))

        return [WorkStep(view, "scaling", 10.0 * len(missing), work)] if missing else []
