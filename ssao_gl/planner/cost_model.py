"""What passes cost: a fixed part, a part for each pixel of the target, and a part for each pixel that is shaded."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..graph.declare import Pass
from ..graph.draws import Fullscreen
from ..graph.plan import Plan, PlannedPass
from ..graph.regions import DrawRegion

DRAWN = ("gbuffer", "layer")
"""Roles of passes that draw the scene: their cost goes by its triangles too."""


@dataclass(frozen=True, slots=True)
class PassWork:
    """Millions of pixels: of the part of a target that a pass draws in, those that it shades, and their taps together."""

    area: float
    shaded: float
    tapped: float = 0.0


@dataclass(frozen=True, slots=True)
class CostRate:
    """Milliseconds: fixed, for a million pixels of the target, for a million that are shaded, and for a million taps."""

    fixed: float
    area: float
    shaded: float
    tapped: float = 0.0

    def ms(self, work: PassWork) -> float:
        """Return what ``work`` costs."""
        return self.fixed + self.area * work.area + self.shaded * work.shaded + self.tapped * work.tapped


Rates = Mapping[str, CostRate]
"""Pass -> its rate."""


@dataclass(frozen=True, slots=True)
class PlannedFrame:
    """How a candidate draws a view: its plan, which part of the frame is drawn, its method and how many taps that makes."""

    plan: Plan
    region: DrawRegion
    method: str
    taps: int

    def work(self, step: PlannedPass, covered: float) -> PassWork:
        """Of one step. covered: share of the image that is not background."""
        every, part = dataclasses.replace(self.region, scene_rect=None).of(step), self.region.of(step)
        whole, area = (1e-6 * w * h for w, h in (rect[2:] if rect else step.size for rect in (every, part)))
        # What is shaded lies in the part that is drawn, however small that is.
        shaded = min(area, whole * covered) if step.task.test else area
        return PassWork(area, shaded, shaded * self.taps if step.task.role == "occlusion" else 0.0)

    def works(self, covered: float) -> dict[str, PassWork]:
        """Of every pass."""
        return {step.task.name: self.work(step, covered) for step in self.plan.steps}


def fitted(measured: Sequence[tuple[PassWork, float]]) -> CostRate:
    """Return the rate that explains some milliseconds best, relatively, without negative parts (by leaving out what would
    be)."""
    ms = np.maximum([time for _, time in measured], 1e-4)
    columns = np.array([(1.0, one.area, one.shaded, one.tapped) for one, _ in measured]) / ms[:, None]
    kept = [i for i in range(4) if columns[:, i].any()]
    while True:
        found = np.linalg.lstsq(columns[:, kept], np.ones(len(ms)), rcond=1e-6)[0]
        if len(kept) == 1 or found.min() >= 0:
            break
        kept.pop(int(found.argmin()))
    rate = np.zeros(4)
    rate[kept] = np.maximum(found, 0)
    return CostRate(*map(float, rate))


@dataclass(frozen=True)
class Measured:
    """A frame of the view in question, timed, and how it compares with what the rates of its candidate say of it.

    Passes of other candidates that are declared alike are taken to cost what they cost here; the others cost what their
    rates say, times how much this frame's passes of their kind (the method's own, or the rest) cost against their rates.
    That takes in how fast the machine is just now, how far taps reach and what is left out by content.
    """

    method: str
    passes: Mapping[str, tuple[PlannedPass, float]]
    """Name -> its declaration, and milliseconds."""
    covered: float
    method_factor: float
    other_factor: float

    @classmethod
    def of(cls, framed: PlannedFrame, ms: Mapping[str, float], covered: float, rates: Rates) -> Measured:
        """``ms``: milliseconds by pass; ``rates``: of its candidate."""
        known = {name: rates[name].ms(one) for name, one in framed.works(covered).items() if name in rates}

        def factor(names: list[str]) -> float:
            return sum(ms[name] for name in names) / max(sum(known[name] for name in names), 1e-6) if names else 1.0

        own = [name for name in known if name == framed.method]
        passes = {step.task.name: (step, ms[step.task.name]) for step in framed.plan.steps}
        return cls(framed.method, passes, covered, factor(own), factor([name for name in known if name != framed.method]))

    def beside(self, other: Measured) -> Measured:
        """Return this frame, with the passes of another that it has not."""
        return dataclasses.replace(self, passes={**other.passes, **self.passes})

    def lacks(self, framed: PlannedFrame, rates: Rates) -> bool:
        """Whether there are passes of which neither this frame nor the rates of the candidate know anything."""
        return not {step.task.name for step in framed.plan.steps} <= {*self.passes, *rates}

    def predict(self, framed: PlannedFrame, rates: Rates) -> float:
        """Milliseconds of a frame by another candidate, whose ``rates`` these are."""
        total = 0.0
        for step in framed.plan.steps:
            name = step.task.name
            same, ms = self.passes.get(name, (None, 0.0))
            if same is not None and step.task.role in DRAWN:
                # Between a cost by triangles and one by pixels.
                total += ms * (math.prod(step.size) / math.prod(same.size)) ** 0.5
            elif same is not None and step.task.role != "occlusion" and _same_work(step, same):
                total += ms
            elif name in rates:
                factor = self.method_factor if name == framed.method == self.method else self.other_factor
                total += factor * rates[name].ms(framed.work(step, self.covered))
        return total


def _same_work(one: PlannedPass, other: PlannedPass) -> bool:
    """Whether two passes cost the same: they differ in the numbers of their uniforms and tables at most."""
    return one.size == other.size and _without_numbers(one.task) == _without_numbers(other.task)


def _without_numbers(task: Pass) -> Pass:
    if not isinstance(task.draw, Fullscreen):
        return task
    return dataclasses.replace(task, draw=dataclasses.replace(task.draw, uniforms={}, tables={}))
