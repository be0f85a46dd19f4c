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
from .fit import Scalars
from .fit_track import fitting_views, gather_levels
from .points import size_text
from .sweep import RAYS, Sweep
from .variants import Variant
from .view_setup import ViewSetup
from .views import MeasuredView

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
        """What can be measured before anything is fitted, as far as it is missing."""
        made = [self._truth(view), self._methods(view), self._rays(view)]
        if self.sweep.split and view.size == self.sweep.views[0].size:
            made.append(self._split(view, self.sweep.split))
        if view in fitting_views(self.sweep):
            made.append(self._levels(view))
        if self.sweep.rules:
            made.append(self._rules(view))
        return [step for step in made if step is not None]

    def fitted(self, view: MeasuredView, found: Mapping[str, Scalars]) -> list[WorkStep]:
        """Measuring under the fits, as far as it is missing."""
        missing = [v for v in self.sweep.variants if v.label in found and not self.has_fitted(view, v, found)]

        def work(setup: ViewSetup, tell: Tell) -> None:
            some = {v.label: (v, setup.settled(v.settings, found[v.label].radius), found[v.label]) for v in missing}
            self._measure(view, setup, "fitted", some, tell)

        return [WorkStep(view, "fitted methods", self.cost(view) * len(missing), work)] if missing else []

    def has_fitted(self, view: MeasuredView, variant: Variant, found: Mapping[str, Scalars]) -> bool:
        """Whether a variant is measured in a view under its fit."""
        key = found[variant.label].key if variant.label in found else ""
        return self.journal.find("fitted", view.name, variant.label, key) is not None

    def cost(self, view: MeasuredView) -> float:
        """Seconds for a variant, about: frames of all rounds, and metrics."""
        return _million(view) * (0.4 * (self.sweep.rounds + 1) + 2)

    def _missing(self, kind: str, view: MeasuredView, at: str = "") -> list[Variant]:
        return [v for v in self.sweep.variants if not self.journal.find(kind, view.name, v.label, at)]

    def _truth(self, view: MeasuredView) -> WorkStep | None:
        if self.journal.find("view", view.name):
            return None

        def work(setup: ViewSetup, tell: Tell) -> None:
            setup.progress = lambda done, total: tell(done / max(total, 1))
            truth = setup.truth
            seen = truth.visibility[setup.depth > 0].astype(float)
            if view.name in self.shown:
                pictures.save_truth(self.folder, view.name, truth.visibility)
            self.journal.add(
                "view", view.name,
                scene=view.scene, camera=view.camera.name, size=view.size, triangles=view.triangles, radius=setup.radius,
                spp=truth.spp, rays=truth.rays, seconds=truth.seconds, cached=truth.cached, stderr=truth.noise,
                covered=float(truth.covered.mean()), pixels=seen.size,
                mean=float(seen.mean()) if seen.size else None, square=float((seen**2).mean()) if seen.size else None,
            )  # fmt: skip

        return WorkStep(view, "truth", _million(view) * (self.sweep.tracing.spp or 1024) / 4, work)

    def _methods(self, view: MeasuredView) -> WorkStep | None:
        missing = self._missing("shipped", view)

        def work(setup: ViewSetup, tell: Tell) -> None:
            some = {v.label: (v, setup.settled(v.settings), Scalars()) for v in missing}
            self._measure(view, setup, "shipped", some, tell)

        return WorkStep(view, "methods", self.cost(view) * len(missing), work) if missing else None

    def _measure(self, view: MeasuredView, setup: ViewSetup, kind: str, some: measure.Some, tell: Tell) -> None:
        """Time and error of some settings in a view, each a row; pictures of what is shipped."""
        frames, count = (self.sweep.rounds + 1) * (len(some) + 1), 0

        def tick() -> None:
            nonlocal count
            count += 1
            tell(0.6 * count / frames)

        timed = measure.timed(setup, {label: settings for label, (_, settings, _) in some.items()}, self.sweep.rounds, tick)
        drawn = {label: some[label][2](setup.draw(some[label][1])) for label in timed.times}
        for (label, visibility), errors in zip(drawn.items(), measure.errors(setup, drawn.values()), strict=True):
            variant, _, scalars = some[label]
            if kind == "shipped":
                self._picture(view, setup, label, visibility)
            values = {
                "times": timed.times[label],
                "yardstick": timed.yardstick,
                "errors": errors,
                "load": measure.machine_load(),
            }
            self._add(kind, view, variant, **values, **_under(kind, scalars))
        for label, reason in timed.refused.items():
            if label in some:
                self._add(kind, view, some[label][0], refused=reason, **_under(kind, some[label][2]))

    def _rays(self, view: MeasuredView) -> WorkStep | None:
        missing = [spp for spp in RAYS if not self.journal.find("rays", view.name, at=str(spp))]

        def work(setup: ViewSetup, tell: Tell) -> None:
            for number, spp in enumerate(missing):
                visibility, times = measure.rays(setup, spp, min(self.sweep.rounds, 3))
                if spp in (RAYS[0], RAYS[-1]):
                    self._picture(view, setup, f"rays {spp}", visibility)
                self.journal.add("rays", view.name, at=str(spp), spp=spp, times=times, errors=setup.errors(visibility))
                tell((number + 1) / len(missing))

        cost = _million(view) * len(missing) * (3 + 0.7 * self.sweep.rounds)
        return WorkStep(view, "rays", cost, work) if missing else None

    def _split(self, view: MeasuredView, size: tuple[int, int]) -> WorkStep | None:
        missing = self._missing("split", view, size_text(size))

        def work(setup: ViewSetup, tell: Tell) -> None:
            small = dataclasses.replace(setup, size=size, progress=None)
            screen = reference_visibility(small)
            for number, variant in enumerate(missing):
                refused = (self.journal.find("shipped", view.name, variant.label) or {}).get("refused")
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

    def _add(self, kind: str, view: MeasuredView, variant: Variant, **values: Any) -> None:
        table = variant.settings.table()
        self.journal.add(
            kind, view.name, variant.label, method=variant.method, preset=variant.preset,
            settings={key: table[key] for key in table if key != "shading"}, **values,
        )  # fmt: skip


def _under(kind: str, scalars: Scalars) -> dict[str, Any]:
    """What tells rows under one fit from those under another."""
    return {"at": scalars.key, "scalars": dataclasses.asdict(scalars)} if kind == "fitted" else {}


def _million(view: MeasuredView) -> float:
    return view.size[0] * view.size[1] / 1e6


def shown_views(sweep: Sweep, most: int) -> Sequence[str]:
    """The first camera of each scene at the first size, so many that their pictures number at most ``most`` pairs."""
    first: dict[str, str] = {}
    for view in sweep.views:
        first.setdefault(view.scene, view.name)
    return list(first.values())[: max(1, most // max(len(sweep.variants), 1))]
