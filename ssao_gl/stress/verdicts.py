"""Runs cases on a driver, and judges what they measure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from ..errors import SettingsError, SsaoError
from ..render.renderer import Renderer
from .case import Case
from .outcomes import NotApplicable
from .runner import SIZE, Broken, CaseRunner
from .shot import Shot
from .specimen import Specimen

PASS, FAIL, DECLARED, ABSENT = "pass", "FAIL", "declared", "n/a"
"""Verdicts: kept; broken; broken as the method declares, within the bound that it gives; nothing to measure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseResult:
    """What came of a case for a subject. ``measured`` is None where nothing could be measured."""

    case: str
    group: str
    method: str
    preset: str
    provider: str
    verdict: str
    unit: str
    bound: float
    measured: float | None = None
    declared: float | None = None
    """Bound that the method declares in place of the case's."""
    reason: str = ""
    folder: str = ""
    """Where the input that fails was written."""
    command: str = ""
    """What replays it."""


@dataclass(frozen=True, eq=False)
class Failure:
    """What is needed to make a failure smaller and to replay it: the row, and what was drawn."""

    row: CaseResult
    case: Case
    subject: Specimen
    shots: tuple[Shot, ...]
    broken: Shot | None
    """The shot that breaks what every picture promises, if that is what failed."""


Failed = Callable[[Failure], CaseResult]
"""What to do with a failure: write it down, and say where."""


def runs(cases: Iterable[Case], subjects: Iterable[Specimen]) -> list[tuple[Case, Specimen]]:
    """Return what is measured: every case for every subject, or for the first one where the method does not matter."""
    every, several = list(cases), list(subjects)
    return [(case, subject) for subject in several for case in every if not case.once or subject is several[0]]


def run_cases(
    renderer: Renderer,
    planned: Iterable[tuple[Case, Specimen]],
    first: Callable[[], Renderer] | None = None,
    failed: Failed = lambda failure: failure.row,
) -> Iterator[CaseResult]:
    """Measure and judge, one row after the other. ``first``: see :class:`.lab.CaseRunner`."""
    for case, subject in planned:
        lab = CaseRunner(renderer, subject, SIZE, first)
        row, broken = judged(case, lab)
        yield row if row.verdict != FAIL else failed(Failure(row, case, subject, tuple(lab.shots), broken))


def judged(case: Case, lab: CaseRunner) -> tuple[CaseResult, Shot | None]:
    """Measure one case. The shot is the one that breaks what every picture promises, if one does."""
    subject = lab.subject
    common: dict[str, Any] = {
        **{"case": case.name, "group": case.group, "unit": case.unit, "bound": case.bound},
        **{"method": subject.name, "preset": subject.preset, "provider": lab.renderer.ctx.provider},
    }
    try:
        measured = float(case.measure(lab))
    except NotApplicable as absence:
        return CaseResult(verdict=ABSENT, reason=str(absence), **common), None
    except Broken as broken:
        return CaseResult(verdict=FAIL, reason=str(broken), **common), broken.shot
    except SettingsError as refusal:
        if any(subject.refuses(kind) for kind in case.asks):
            return CaseResult(verdict=DECLARED, declared=math.inf, reason=str(refusal), **common), None
        return CaseResult(verdict=FAIL, reason=str(refusal), **common), None
    except Exception as error:  # whatever else a driver or a case does wrong is a failure, not the end
        kind = "" if isinstance(error, SsaoError) else f"unforeseen {type(error).__name__}: "
        return CaseResult(verdict=FAIL, reason=kind + " ".join(str(error).split()), **common), None
    if measured <= case.bound:
        return CaseResult(verdict=PASS, measured=measured, **common), None
    deviation = subject.exceptions.get(case.contract)
    if deviation is None:
        return CaseResult(verdict=FAIL, measured=measured, reason=f"not kept: {case.promise}", **common), None
    verdict = DECLARED if measured <= deviation.bound else FAIL
    return CaseResult(verdict=verdict, measured=measured, declared=deviation.bound, reason=deviation.reason, **common), None
