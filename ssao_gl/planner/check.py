"""How good plans are; ``ssao-gl planner check`` says it.

For every camera of the camera file beside each scene: every candidate is predicted, and then drawn, timed and held against
rays. Says how far predicted times and errors were off, and how much worse than the best of all candidates the planner's
choices are under budgets and bounds over the whole range. Times are also compared after taking out how much faster or
slower the machine had become since the plan, by one and the same frame timed again beside each candidate: ``paired``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import SettingsError
from ..io.cache import default_folder
from ..pipeline.settings import Settings
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth import Tracing, trace
from .candidates import CANDIDATES, PROBES
from .choice import Prediction, Target, choose, times
from .measure import SPP, foreground_rmse
from .plan import ROUNDS, plan

ALL = Target(budget_ms=1e9)
STEPS = 9
"""Budgets, and bounds on the error, that are tried in a view: evenly spread, in logarithms, over what can be had."""


@dataclass(frozen=True)
class Outcome:
    """A candidate in a view: what was predicted and what it was. ``drift``: how much slower the machine had become."""

    view: str
    name: str
    predicted_ms: float
    ms: float
    drift: float
    predicted_error: float
    error: float

    @property
    def expected(self) -> Prediction:
        return Prediction(self.name, self.predicted_ms, self.predicted_error)

    @property
    def found(self) -> Prediction:
        return Prediction(self.name, self.ms / self.drift, self.error)


def outcomes(renderer: Renderer, scene: Scene, camera: Camera, size: Size) -> list[Outcome]:
    """Every candidate in one view."""
    truth = trace(scene, camera, size, Tracing(spp=SPP), cache=default_folder())
    depth = renderer.render(scene, camera, size, aovs=("depth",)).depth
    choice = plan(renderer, scene, camera, size, ALL, aovs=("visibility",))
    radius = choice.settings.method.radius

    def drawn(name: str) -> tuple[float, float]:
        settings = dataclasses.replace(choice.settings, method=CANDIDATES[name][1].made(radius))
        picture = renderer.render(scene, camera, size, settings, aovs=("visibility",), visibility_bits=8, timed=ROUNDS)
        return sum(times(picture.report["passes"], choice.clock).values()), foreground_rmse(picture.visibility, truth, depth)

    yardstick = PROBES[Settings().method.name][1]
    expected = next(p.ms for p in choice.considered if p.name == yardstick)
    found = []
    for one in choice.considered:
        beside, (ms, error) = drawn(yardstick)[0], drawn(one.name)
        drift = beside / expected
        found.append(Outcome(f"{scene.name}:{camera.name}", one.name, one.ms, ms, drift, one.error, error))
    return found


def worse(found: Sequence[Outcome]) -> dict[str, list[float]]:
    """How many times worse than the best choice the planner's are in one view: errors under budgets, times under bounds.

    Predictions are held against what was measured with the machine's drift taken out. Budgets and bounds for which
    either finds nothing are left out.
    """
    measured = {one.name: one.found for one in found}
    ratios: dict[str, list[float]] = {"error": [], "ms": [], "overrun": []}
    for kind in ("error", "ms"):
        limits = [one.ms if kind == "error" else one.error for one in measured.values()]
        for limit in np.geomspace(min(limits), max(limits), STEPS):
            target = Target(budget_ms=limit) if kind == "error" else Target(max_error=limit)
            try:
                chosen = measured[choose([one.expected for one in found], target).name]
                best = choose(list(measured.values()), target)
            except SettingsError:
                continue
            ratios[kind].append(getattr(chosen, kind) / max(getattr(best, kind), 1e-6))
            if kind == "error":
                ratios["overrun"].append(chosen.ms / limit)
    return ratios


def check_lines(found: Mapping[str, Sequence[Outcome]]) -> list[str]:
    """Lines about all views."""
    every = [one for some in found.values() for one in some]
    apart = _misses(every)
    lines = [
        f"{name}: off by {100 * np.median(np.abs(off)):.1f} % (median), {100 * np.mean(np.abs(off)):.1f} % (mean); {100 * np.median(off):+.1f} % all in all"
        for name, off in apart.items()
    ]
    ratios = [worse(some) for some in found.values()]
    for kind, text in (
        ("error", "error of the choice within a budget over that of the best"),
        ("ms", "time of the choice within an error over that of the best"),
        ("overrun", "time of the choice over its budget"),
    ):
        some = np.array([x for one in ratios for x in one[kind]])
        lines.append(
            f"{text}: {np.median(some):.3f} (median), {some.mean():.3f} (mean), {np.quantile(some, 0.9):.3f} (9 of 10), {len(some)} targets"
        )
    return lines


def view_line(some: Sequence[Outcome]) -> str:
    """Return a line about one view: medians over its candidates of how far predictions were off."""
    time, paired, error = (100 * float(np.median(np.abs(misses))) for misses in _misses(some).values())
    view = some[0].view
    return f"{view}: time off by {time:.1f} %, paired {paired:.1f} %, error {error:.1f} % (medians of {len(some)})"


def _misses(some: Sequence[Outcome]) -> dict[str, list[float]]:
    """Return what was measured over what was predicted, less 1."""
    return {
        "time": [one.ms / one.predicted_ms - 1 for one in some],
        "time, paired": [one.ms / one.drift / one.predicted_ms - 1 for one in some],
        "error": [one.error / one.predicted_error - 1 for one in some],
    }
