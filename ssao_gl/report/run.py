"""Measures everything a report is asked for, step by step; what the journal has already is left out."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..renderer import Renderer
from ..scene import Scene
from . import pictures, scaling, shipped
from .fit import Scalars
from .fitting import fits, fitting_views, gather_levels
from .journal import Journal
from .setup import Setup
from .split import reference, split
from .sweep import RAYS, Progress, Sweep
from .variants import Variant
from .views import View, by_scene

Work = Callable[[Setup, Callable[[float], None]], None]

MOST_PICTURES = 300
"""Methods in all views of the page together: so many pairs of small pictures at most."""


@dataclass(frozen=True, eq=False, slots=True)
class Step:
    """A piece of work in one view. ``cost`` is a guess of its seconds, for the time left; the work tells its share done."""

    view: View
    title: str
    cost: float
    work: Work


class Run:
    """One run over a sweep: ``Run(...).measure()``."""

    def __init__(
        self, sweep: Sweep, renderer: Renderer, journal: Journal, folder: Path, cache: Path | None, progress: Progress
    ) -> None:
        self.sweep, self.renderer, self.journal = sweep, renderer, journal
        self.folder, self.cache, self.progress = folder, cache, progress
        self._shown = grid_views(sweep)
        self._done = self._total = 0.0

    def measure(self) -> None:
        """All steps. Whatever ends it, finished rows are in the journal."""
        ahead = self._fitted_cost()
        self._work([step for view in self.sweep.views for step in self._first(view)], ahead)
        found = fits(self.sweep, self.journal)
        steps = [step for view in self.sweep.views for step in self._second(view, {k: v[0] for k, v in found.items()})]
        if self.sweep.scaling:
            steps += self._scaling()
        self._work(steps, 0.0)

    def _work(self, steps: Sequence[Step], ahead: float) -> None:
        """Do the steps; ``ahead`` is the cost of what comes after them."""
        self._total = self._done + sum(step.cost for step in steps) + ahead
        for scene, views in by_scene([step.view for step in steps]):
            for view in dict.fromkeys(views):
                setup = self._setup(scene, view)
                for step in (step for step in steps if step.view is view):
                    self._step(step, setup)

    def _step(self, step: Step, setup: Setup) -> None:
        began, title = self._done, f"{step.view.scene}:{step.view.camera.name} {step.title}"

        def tell(share: float) -> None:
            self.progress(title, began + step.cost * min(share, 1.0), self._total)

        tell(0.0)
        setup.progress = (lambda done, total: tell(done / max(total, 1))) if step.title == "truth" else None
        step.work(setup, tell)
        self._done = began + step.cost
        self.progress(title, self._done, self._total)

    def _setup(self, scene: Scene, view: View) -> Setup:
        return Setup(self.renderer, scene, view.camera, view.size, self.sweep.tracing, self.cache)

    def _first(self, view: View) -> list[Step]:
        """What can be measured before anything is fitted."""
        find, name = self.journal.find, view.name
        million = view.size[0] * view.size[1] / 1e6
        every = self.sweep.variants
        missing = [v for v in every if not find("shipped", name, v.label)]
        steps = []
        if not find("view", name):
            steps.append(Step(view, "truth", million * (self.sweep.tracing.spp or 1024) / 4, self._truth(view)))
        if missing:
            cost = million * len(missing) * (0.4 * (self.sweep.rounds + 1) + 2)
            steps.append(Step(view, "methods", cost, self._methods(view, missing)))
        rays = [spp for spp in RAYS if not find("rays", name, at=str(spp))]
        if rays:
            steps.append(Step(view, "rays", million * len(rays) * (3 + 0.7 * self.sweep.rounds), self._rays(view, rays)))
        if self.sweep.split and view.size == self.sweep.views[0].size:
            lacking = [v for v in every if not find("split", name, v.label)]
            if lacking:
                steps.append(Step(view, "error split", 8 + 0.5 * len(lacking), self._split(view, self.sweep.split, lacking)))
        if view in fitting_views(self.sweep):
            unfitted = [v for v in every if not find("levels", name, v.label)]
            if unfitted:
                steps.append(Step(view, "fit", million * 3 * len(unfitted), self._levels(view, unfitted)))
        return steps

    def _second(self, view: View, found: dict[str, Scalars]) -> list[Step]:
        """What needs the fits."""
        missing = [v for v in self.sweep.variants if v.label in found and not self.journal.find("fitted", view.name, v.label)]
        cost = self._second_cost(view) * len(missing)
        return [Step(view, "fitted methods", cost, self._fitted(view, missing, found))] if missing else []

    def _second_cost(self, view: View) -> float:
        return view.size[0] * view.size[1] / 1e6 * (0.4 * (self.sweep.rounds + 1) + 2)

    def _fitted_cost(self) -> float:
        if not self.sweep.fit:
            return 0.0
        missing = [
            view
            for view in self.sweep.views
            for v in self.sweep.variants
            if not self.journal.find("fitted", view.name, v.label)
        ]
        return sum(map(self._second_cost, missing))

    def _truth(self, view: View) -> Work:
        def work(setup: Setup, tell: Callable[[float], None]) -> None:
            truth = setup.truth
            seen = truth.visibility[setup.depth > 0].astype(float)
            if view in self._shown:
                pictures.save_truth(self.folder, view.name, truth.visibility)
            self.journal.add(
                "view", view.name,
                scene=view.scene, camera=view.camera.name, size=view.size, triangles=view.triangles, radius=setup.radius,
                spp=truth.spp, rays=truth.rays, seconds=truth.seconds, cached=truth.cached, stderr=truth.noise,
                covered=float(truth.covered.mean()), pixels=seen.size,
                mean=float(seen.mean()) if seen.size else None, square=float((seen**2).mean()) if seen.size else None,
            )  # fmt: skip

        return work

    def _methods(self, view: View, missing: Sequence[Variant]) -> Work:
        def work(setup: Setup, tell: Callable[[float], None]) -> None:
            self._measure(view, setup, "shipped", {v.label: (v, setup.settled(v.settings), Scalars()) for v in missing}, tell)

        return work

    def _fitted(self, view: View, missing: Sequence[Variant], found: dict[str, Scalars]) -> Work:
        def work(setup: Setup, tell: Callable[[float], None]) -> None:
            some = {v.label: (v, setup.settled(v.settings, found[v.label].radius), found[v.label]) for v in missing}
            self._measure(view, setup, "fitted", some, tell)

        return work

    def _measure(self, view: View, setup: Setup, kind: str, some: shipped.Some, tell: Callable[[float], None]) -> None:
        """Time and error of some settings in a view, each a row; pictures of what is shipped."""
        frames, count = (self.sweep.rounds + 1) * (len(some) + 1), 0

        def tick() -> None:
            nonlocal count
            count += 1
            tell(0.6 * count / frames)

        timed = shipped.timed(setup, {label: settings for label, (_, settings, _) in some.items()}, self.sweep.rounds, tick)
        drawn = {label: some[label][2](setup.draw(some[label][1])) for label in timed.times}
        measured = shipped.errors(setup, drawn.values())
        for (label, visibility), errors in zip(drawn.items(), measured, strict=True):
            variant, _, scalars = some[label]
            if kind == "shipped" and view in self._shown:
                pictures.save_method(self.folder, view.name, label, visibility, setup.truth.visibility, setup.depth > 0)
            values = {"times": timed.times[label], "yardstick": timed.yardstick, "errors": errors}
            values |= {"scalars": dataclasses.asdict(scalars)} if kind == "fitted" else {}
            self._add(kind, view, variant, load=shipped.load(), **values)
        for label, reason in timed.refused.items():
            if label in some:
                self._add(kind, view, some[label][0], refused=reason)

    def _add(self, kind: str, view: View, variant: Variant, **values: Any) -> None:
        table = variant.settings.table()
        self.journal.add(
            kind, view.name, variant.label, method=variant.method, preset=variant.preset,
            settings={key: table[key] for key in table if key != "shading"}, **values,
        )  # fmt: skip

    def _rays(self, view: View, missing: Sequence[int]) -> Work:
        def work(setup: Setup, tell: Callable[[float], None]) -> None:
            for number, spp in enumerate(missing):
                visibility, times = shipped.rays(setup, spp, min(self.sweep.rounds, 3))
                if view in self._shown and spp in (1, 8):
                    label = f"rays {spp}"
                    pictures.save_method(self.folder, view.name, label, visibility, setup.truth.visibility, setup.depth > 0)
                self.journal.add("rays", view.name, at=str(spp), spp=spp, times=times, errors=setup.errors(visibility))
                tell((number + 1) / len(missing))

        return work

    def _split(self, view: View, size: tuple[int, int], missing: Sequence[Variant]) -> Work:
        def work(setup: Setup, tell: Callable[[float], None]) -> None:
            small = dataclasses.replace(setup, size=size, progress=None)
            screen = reference(small)
            for number, variant in enumerate(missing):
                refused = (self.journal.find("shipped", view.name, variant.label) or {}).get("refused")
                parts = {"refused": refused} if refused else split(small, screen, variant.settings)
                self._add("split", view, variant, size=size, **parts)
                tell(0.3 + 0.7 * (number + 1) / len(missing))

        return work

    def _levels(self, view: View, missing: Sequence[Variant]) -> Work:
        def work(setup: Setup, tell: Callable[[float], None]) -> None:
            for number, variant in enumerate(missing):
                levels = gather_levels(setup, variant)
                self.journal.add("levels", view.name, variant.label, levels=levels)
                tell((number + 1) / len(missing))

        return work

    def _scaling(self) -> list[Step]:
        view = self.sweep.views[0]
        missing = [
            one for one in scaling.trials(self.sweep, view) if not self.journal.find("scaling", view.name, one.label, one.at)
        ]

        def work(setup: Setup, tell: Callable[[float], None]) -> None:
            for number, one in enumerate(missing):
                self.journal.add("scaling", view.name, one.label, one.at, **scaling.measure(setup, one, self.sweep.rounds))
                tell((number + 1) / len(missing))

        return [Step(view, "scaling", 10.0 * len(missing), work)] if missing else []


def grid_views(sweep: Sweep) -> list[View]:
    """Views with pictures on the page: the first camera of each scene at the first size, as far as pictures are bounded."""
    first: dict[str, View] = {}
    for view in sweep.views:
        first.setdefault(view.scene, view)
    return list(first.values())[: max(1, math.floor(MOST_PICTURES / max(len(sweep.variants), 1)))]
