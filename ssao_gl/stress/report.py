"""The result of a run, as data and as a page that needs nothing else."""

from __future__ import annotations

import collections
import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..io.atomic import atomic_write
from ..io.pages import page
from .fuzz import PREFIX
from .verdicts import ABSENT, DECLARED, FAIL, PASS, CaseResult

SUFFIXES = (".html", ".json")
VERDICTS = (PASS, DECLARED, ABSENT, FAIL)


@dataclass
class StressResults:
    """Rows of named cases, failing rows of random ones, and how many random ones there were."""

    rows: list[CaseResult] = field(default_factory=list)
    random: collections.Counter[tuple[str, str, str, str]] = field(default_factory=collections.Counter)
    """(provider, method, preset, verdict) -> random cases."""

    def add(self, row: CaseResult) -> None:
        """Count a row; of random cases that pass only the number is kept."""
        if row.case.startswith(PREFIX):
            self.random[row.provider, row.method, row.preset, row.verdict] += 1
        if row.verdict == FAIL or not row.case.startswith(PREFIX):
            self.rows.append(row)

    @property
    def failed(self) -> list[CaseResult]:
        return [row for row in self.rows if row.verdict == FAIL]

    @property
    def named(self) -> list[CaseResult]:
        return [row for row in self.rows if not row.case.startswith(PREFIX)]

    def tallies(self, provider: str) -> list[tuple[str, str, str, int]]:
        """Return (method, preset, verdict, number) of a provider's random cases."""
        return [(*key[1:], number) for key, number in self.random.items() if key[0] == provider]

    def counts(self) -> dict[str, int]:
        """Verdict -> number of rows, random cases included."""
        found = collections.Counter(row.verdict for row in self.named)
        for (_, _, _, verdict), number in self.random.items():
            found[verdict] += number
        return {verdict: found[verdict] for verdict in VERDICTS}


def save_stress_report(path: Path, results: StressResults, facts: Mapping[str, Any]) -> None:
    """Write the results by suffix, whole or not at all. Raises FormatError."""
    text = (
        stress_page(results, facts) if path.suffix.lower() == ".html" else json.dumps(as_data(results, facts), indent=1) + "\n"
    )
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8")


def as_data(results: StressResults, facts: Mapping[str, Any]) -> dict[str, Any]:
    """Plain values for JSON; infinite bounds are null."""
    rows = [{key: _plain(value) for key, value in dataclasses.asdict(row).items()} for row in results.rows]
    random = [
        dict(zip(("provider", "method", "preset", "verdict", "cases"), (*key, n), strict=True))
        for key, n in results.random.items()
    ]
    return {**facts, "counts": results.counts(), "rows": rows, "random": random}


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def cell(row: CaseResult) -> str:
    """Return a row in few characters: what was measured, and the declared bound beside it."""
    measured = "" if row.measured is None else f"{max(row.measured, 0):.2g}"
    if row.verdict == DECLARED:
        return f"{measured} <= {row.declared:g} declared" if row.measured is not None else "refuses, declared"
    return {PASS: measured, ABSENT: "n/a", FAIL: f"FAIL {measured}".strip()}[row.verdict]


def matrix(rows: Sequence[CaseResult]) -> tuple[list[str], list[list[str]]]:
    """(columns, lines) of one provider's rows: cases down, methods with their presets across."""
    labels = list(dict.fromkeys(_label(row) for row in rows))
    lines: dict[str, dict[str, str]] = {}
    for row in rows:
        lines.setdefault(row.case, {})[_label(row)] = cell(row)
    return ["case", *labels], [[case, *(found.get(label, "") for label in labels)] for case, found in lines.items()]


def _label(row: CaseResult) -> str:
    return row.method if row.preset == "default" else f"{row.method}:{row.preset}"


@dataclass(frozen=True, slots=True)
class PageTable:
    """A table of the page."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]


def stress_page(results: StressResults, facts: Mapping[str, Any]) -> str:
    """Return all of it as HTML."""
    named = ("case", "method", "preset", "provider", "verdict", "measured", "what", "bound", "declared", "why")
    tables = [
        PageTable(
            "Failures",
            ("case", "method", "provider", "reason", "measured", "bound", "replay"),
            [_failure(row) for row in results.failed],
        ),
        PageTable("Named cases", named, [_named(row) for row in results.named]),
        PageTable(
            "Random cases",
            ("provider", "method", "preset", "verdict", "cases"),
            [(*key, n) for key, n in results.random.items()],
        ),
    ]
    return page(
        __package__,
        "stress.html",
        title="Numerical stability of ambient occlusion",
        lead=", ".join(f"{number} {verdict}" for verdict, number in results.counts().items()),
        command=str(facts.get("command", "")),
        tables=tables,
        fail=FAIL,
        facts={key: value for key, value in facts.items() if key != "command"},
        text=_text,
    )


def _failure(row: CaseResult) -> tuple[Any, ...]:
    return row.case, _label(row), row.provider, row.reason, row.measured, row.bound, row.command


def _named(row: CaseResult) -> tuple[Any, ...]:
    declared = "refuses" if row.declared == math.inf else row.declared
    return row.case, row.method, row.preset, row.provider, row.verdict, row.measured, row.unit, row.bound, declared, row.reason


def _text(value: Any) -> str:
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
