"""The pieces of work in one view: what is missing in the journal, what it will cost, and how it is measured."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..io.journal import Journal
from . import culling_rules, measure, pictures
from .error_split import reference_visibility, split_error
from .estimators import Estimator, ScreenSpace
from .fit import Scalars
from .fit_track import fitting_views, gather_levels
from .points import size_text
from .sweep import Sweep
from .view_setup import ViewSetup
from .views import MeasuredView

ESTIMATE = "estimate"
"""Kind of the journal's rows of estimators as they are."""

Tell = Callable[[float], None]
"""Called with the share of a step that is done."""


@dataclass(frozen=True, eq=False, slots=True)
class WorkStep:
    """A piece of work in one view. ``cost`` is a guess of its seconds, for the time left."""

    view: MeasuredView
    title: str
    cost: float
    work: Callable[[ViewSetup, Tell], None]


@dataclass(frozen=True, eq=False)
class WorkSteps:
    """Makes the steps of a sweep. ``shown``: names of the views that get pictures, in ``folder``."""

    sweep: Sweep
    journal: Journal
    folder: Path
    shown: Collection[str]

    def unfitted(self, view: MeasuredView) -> list[WorkStep]:
        """Return what can be measured before anything is fitted, as far as it is missing."""
        made = [self._truth(view), self._estimates(view)]
        if self.sweep.split and view.size == self.sweep.views[0].size:
            made.append(self._split(view, self.sweep.split))
        if view in fitting_views(self.sweep):
            made.append(self._levels(view))
        if self.sweep.rules:
            made.append(self._rules(view))
        return [step for step in made if step is not None]

    def fitted(self, view: MeasuredView, found: Mapping[str, Scalars]) -> list[WorkStep]:
        """Measuring under the fits, as far as it is missing."""
        missing = [one for one in self.sweep.methods if one.label in found and not self.has_fitted(view, one, found)]

        def work(setup: ViewSetup, tell: Tell) -> None:
            some = {one.label: dataclasses.replace(one, radius_factor=found[one.label].radius) for one in missing}
            self._measure(view, setup, "fitted", some, found, tell)

        return [WorkStep(view, "fitted methods", self.cost(view) * len(missing), work)] if missing else []

    def has_fitted(self, view: MeasuredView, variant: ScreenSpace, found: Mapping[str, Scalars]) -> bool:
        """Whether a variant is measured in a view under its fit."""
        key = found[variant.label].key if variant.label in found else ""
        return self.journal.find("fitted", view.name, variant.label, key) is not None

    def cost(self, view: MeasuredView) -> float:
        """Seconds for a variant, about: frames of all rounds, and metrics."""
        return _million(view) * (0.4 * (self.sweep.rounds + 1) + 2)

    def _missing(self, kind: str, view: MeasuredView, at: str = "") -> list[ScreenSpace]:
        return [one for one in self.sweep.methods if not self.journal.find(kind, view.name, one.label, at)]

    def _truth(self, view: MeasuredView) -> WorkStep | None:
        if self.journal.find("view", view.name):
            return None

        def work(setup: ViewSetup, tell: Tell) -> None:
            setup.progress = lambda done, total: tell(done / max(total, 1))
            truth = setup.truth
            seen = truth.visibility[setup.depth > 0].astype(float)
            if view.name in self.shown:
                pictures.save_truth(self.folder, view.name, truth.visibility, setup.zones)
            self.journal.add(
                "view", view.name,
                scene=view.scene, camera=view.camera.name, size=view.size, triangles=view.triangles, radius=setup.radius,
                spp=truth.spp, rays=truth.rays, seconds=truth.seconds, cached=truth.cached, stderr=truth.noise,
                covered=float(truth.covered.mean()), pixels=seen.size, zones=setup.zones.shares(),
                mean=float(seen.mean()) if seen.size else None, square=float((seen**2).mean()) if seen.size else None,
            )  # fmt: skip

        return WorkStep(view, "truth", _million(view) * (self.sweep.tracing.spp or 1024) / 4, work)

    def _estimates(self, view: MeasuredView) -> WorkStep | None:
        missing = [one for one in self.sweep.estimators if not self.journal.find(ESTIMATE, view.name, one.label)]

        def work(setup: ViewSetup, tell: Tell) -> None:
            self._measure(view, setup, ESTIMATE, {one.label: one for one in missing}, {}, tell)

        return WorkStep(view, "estimators", self.cost(view) * len(missing), work) if missing else None

    def _measure(
        self,
        view: MeasuredView,
        setup: ViewSetup,
        kind: str,
        some: Mapping[str, Estimator],
        fits: Mapping[str, Scalars],
        tell: Tell,
    ) -> None:
        """Time and error of some estimators in a view, each a row; pictures of those that are not fitted."""
        frames, count = (self.sweep.rounds + 1) * (len(some) + 1), 0

        def tick() -> None:
            nonlocal count
            count += 1
            tell(0.6 * count / frames)

        found = measure.timed(setup, some, self.sweep.rounds, tick)
        drawn = {label: fits[label](one.draw()) if label in fits else one.draw() for label, one in found.ready.items()}
        for (label, visibility), errors in zip(drawn.items(), measure.errors(setup, drawn.values()), strict=True):
            if kind == ESTIMATE and some[label].pictured:
                self._picture(view, setup, label, visibility)
            values = {"times": found.times[label], "baseline": found.baseline, "errors": errors, "load": measure.machine_load()}
            prepared = dataclasses.asdict(found.ready[label].preparation)
            self._add(kind, view, some[label], **values, prepared=prepared, **_under(kind, fits.get(label)))
        for label, reason in found.refused.items():
            if label in some:
                self._add(kind, view, some[label], refused=reason, **_under(kind, fits.get(label)))

    def _split(self, view: MeasuredView, size: tuple[int, int]) -> WorkStep | None:
        missing = self._missing("split", view, size_text(size))

        def work(setup: ViewSetup, tell: Tell) -> None:
            small = dataclasses.replace(setup, size=size, progress=None)
            screen = reference_visibility(small)
            for number, variant in enumerate(missing):
                refused = (self.journal.find(ESTIMATE, view.name, variant.label) or {}).get("refused")
                parts = {"refused": refused} if refused else split_error(small, screen, variant.settings)
                self._add("split", view, variant, at=size_text(size), size=size, **parts)
                tell(0.3 + 0.7 * (number + 1) / len(missing))

        return WorkStep(view, "error split", 8 + 0.8 * len(missing), work) if missing else None

    def _levels(self, view: MeasuredView) -> WorkStep | None:
        missing = self._missing("levels", view)

        def work(setup: ViewSetup, tell: Tell) -> None:
            for number, variant in enumerate(missing):
                self.journal.add("levels", view.name, variant.label, levels=gather_levels(setup, variant))
                tell((number + 1) / len(missing))

        return WorkStep(view, "fit", _million(view) * 3 * len(missing), work) if missing else None

    def _rules(self, view: MeasuredView) -> WorkStep | None:
        if self.journal.find("rules", view.name):
            return None

        def work(setup: ViewSetup, tell: Tell) -> None:
            self.journal.add("rules", view.name, rules=culling_rules.measure_rules(setup, self.sweep.rounds, tell))

        return WorkStep(view, "rules of leaving out", 20 * _million(view), work)

    def _picture(self, view: MeasuredView, setup: ViewSetup, label: str, visibility: measure.F32) -> None:
        if view.name in self.shown:
            pictures.save_method(self.folder, view.name, label, visibility, setup.truth.visibility, setup.depth > 0)

    def _add(self, kind: str, view: MeasuredView, one: Estimator, **values: Any) -> None:
        about: dict[str, Any] = {"family": one.family, "preset": one.preset, "realtime": one.realtime, "settings": one.table()}
        self.journal.add(kind, view.name, one.label, **about, **values)


def _under(kind: str, scalars: Scalars | None) -> dict[str, Any]:
    """Return what tells rows under one fit from those under another."""
    return {"at": scalars.key, "scalars": dataclasses.asdict(scalars)} if kind == "fitted" and scalars else {}


def _million(view: MeasuredView) -> float:
    return view.size[0] * view.size[1] / 1e6


def shown_views(sweep: Sweep, most: int) -> Sequence[str]:
    """Return the first camera of each scene at the first size, so many that their pictures number at most ``most`` pairs."""
    first: dict[str, str] = {}
    for view in sweep.views:
        first.setdefault(view.scene, view.name)
    return list(first.values())[: max(1, most // max(len(sweep.methods), 1))]
