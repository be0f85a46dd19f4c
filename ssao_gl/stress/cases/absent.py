"""Traps that are sprung by text or plan, and those that cannot occur here, with the reason why."""

from __future__ import annotations

import re

from ...glsl.preprocess import build
from ...graph.plan import Plan
from ...pipeline.build import plan_apply, plan_render
from ..case import case
from ..outcomes import NotApplicable
from ..runner import CaseRunner
from ..shapes import lens
from ..shot import Shot

GROUP = "by construction"


@case("feedback-loop", GROUP, "steps that read what they draw into", 0.0, traps=(45,), why="none")
def feedback(lab: CaseRunner) -> float:
    """No pass reads a texture while it draws into it."""
    settings = lab.subject.settings(Shot(lens(), blur="joint"))
    plans = [plan_render(settings, lab.size)]
    if settings.method.traits.draws_arrays:
        plans += [plan_apply(settings, lab.size, normals=normals) for normals in (False, True)]
    return float(sum(_loops(plan) for plan in plans))


def _loops(plan: Plan) -> int:
    return sum(
        bool({plan.where[name] for name in step.task.reads if name in plan.where} & set(step.slots)) for step in plan.steps
    )


@case("half-precision", GROUP, "words", 0.0, traps=(5, 6, 40), why="none")
def precision(lab: CaseRunner) -> float:
    """Floats, integers and samplers are of 32 bits by default, and nothing is mediump or lowp but what is declared LOW."""
    method = lab.subject.settings(Shot(lens())).method
    text = re.sub(r"//.*|#define LOW mediump", "", build(method.shader, method.defines()).text)
    wanted = ("precision highp float;", "precision highp int;", "precision highp sampler2D;")
    return float(len(re.findall("mediump|lowp", text)) + sum(line not in text for line in wanted))


def _never(name: str, promise: str, trap: int, reason: str) -> None:
    def measure(lab: CaseRunner) -> float:
        raise NotApplicable(reason)

    measure.__doc__ = promise
    case(name, GROUP, "nothing", 0.0, traps=(trap,), why=f"cannot occur: {reason}", once=True)(measure)


_never("history-nan", "A NaN in the history is gone in the next frame", 29, "there is no history: every frame starts anew")
_never("history-of-8-bits", "An average over frames converges in 8 bits", 30, "there is no history: every frame starts anew")
_never(
    "alpha",
    "Cut-outs and blended surfaces occlude as far as they cover",
    38,
    "the renderer knows no alpha: every triangle is opaque",
)
_never(
    "two-depths",
    "Occlusion's depth is that of the colour",
    41,
    "depth, normals and colour come from one draw; a second layer starts behind the first by more than its rounding",
)
