"""``ssao-gl stress``: is ambient occlusion numerically stable on this driver?"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import ContextError, SettingsError, near_miss
from ..gl.providers import PROVIDERS
from ..io.atomic import check_writable
from ..render.renderer import Renderer
from ..stress.case import Case
from ..stress.case_table import COLUMNS, case_table_markdown, rows
from ..stress.catalogue import cases
from ..stress.fuzz import PREFIX, planned, random_case
from ..stress.replay import Recorder, replayed
from ..stress.report import SUFFIXES, StressResults, matrix, save_stress_report
from ..stress.specimen import DEFAULT, Specimen, specimens
from ..stress.verdicts import FAIL, run_cases, runs
from .output import check_output, print_table, progress, say
from .tokens import WHOLE

Listed = tuple[str, ...]
ACROSS = 10
"""Columns of results that fit on a page."""
KEEP = 32
"""Plans whose textures stay: cases come back to a handful of sizes."""
RANDOM = 300
"""Random cases of the short form."""


def _option(text: str, *names: str) -> Parameter:
    return Parameter(name=list(names) or None, help=text, negative="", show_default=False)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class CaseOptions:
    """What is asked of which methods."""

    methods: Annotated[Listed, _option("Methods by commas. [default: all]")] = ()
    presets: Annotated[Listed, _option("Presets by commas, or all. [default: every method as shipped]")] = ()
    precision: Annotated[str, Parameter(help="Of the shaders: high or mobile.")] = "high"
    seed: Annotated[int, WHOLE, Parameter(help="Of the random cases.")] = 0
    number: Annotated[
        int | None, WHOLE, _option(f"Random cases, over all methods. [default: {RANDOM}; none with --only]", "--cases")
    ] = None
    only: Annotated[Listed, _option(f"Cases by commas; {PREFIX}N is the random case N. [default: all]")] = ()

    def cases(self) -> tuple[list[Case], int]:
        """Return the named cases and the number of random ones. Raises SettingsError."""
        if self.seed < 0 or (self.number or 0) < 0:
            raise SettingsError(f"--seed {self.seed} --cases {self.number}: must not be negative")
        count = RANDOM if self.number is None and not self.only else self.number or 0
        return _named(_split(self.only), self.seed), count

    def specimens(self) -> list[Specimen]:
        """Return the methods under their presets. Raises SettingsError."""
        return specimens(_split(self.methods), _split(self.presets) or [DEFAULT], self.precision)


def stress(
    *,
    asked: CaseOptions = CaseOptions(),
    gl: Annotated[
        str,
        Parameter(help="OpenGL provider: auto, egl-es, egl-gl, osmesa, angle, swiftshader, native; all: each that opens."),
    ] = "auto",
    listed: Annotated[bool, _option("Print the table of cases, and draw nothing.", "--list")] = False,
    as_page: Annotated[bool, _option("With --list: print it as a page of Markdown.", "--markdown")] = False,
    failures: Annotated[Path, _option("Folder for inputs that fail. [default: stress-failures]")] = Path("stress-failures"),
    replay: Annotated[Path | None, _option("Draw again one that failed: a folder in --failures. [default: none]")] = None,
    output: Annotated[Path | None, _option("Write the results, HTML or JSON. [default: none]", "--output", "-o")] = None,
) -> int:
    """Try every method on extreme, broken and random input, and check what every picture promises.

    Exits with 1 when a case fails; its input is then written to a folder, as small as it gets, with the command that
    replays it.
    """
    if listed:
        _list(as_page)
        return 0
    if output is not None:
        check_output("-o", output, SUFFIXES)
    if replay is not None:
        return _replay(replay, gl)
    (named, count), chosen, seed = asked.cases(), asked.specimens(), asked.seed
    steady = runs(named, chosen)
    check_writable(failures, folder=True)
    results, facts = StressResults(), {"command": shlex.join(["ssao-gl", *sys.argv[1:]]), "seed": str(seed)}
    with ExitStack() as stack:
        first = cache(lambda: stack.enter_context(Renderer("auto", keep=KEEP)))
        for renderer in _renderers(gl):
            name = renderer.ctx.provider
            facts[name] = f"{renderer.ctx.version}, {renderer.ctx.renderer}"
            plan = chain(steady, planned(seed, range(count), chosen))
            found = run_cases(renderer, plan, first, Recorder(renderer, failures, seed))
            for row in progress(found, f"stress, {name}", len(steady) + count):
                results.add(row)
            _show(name, facts[name], results)
    return _conclude(results, facts, output)


def _renderers(gl: str) -> Iterator[Renderer]:
    """Yield the chosen provider, or each that opens, one after the other. Raises ContextError when none does."""
    if gl != "all":
        with Renderer(gl, keep=KEEP) as renderer:
            yield renderer
        return
    opened = 0
    for name in PROVIDERS:
        try:
            renderer = Renderer(name, keep=KEEP)
        except (ContextError, OSError, ImportError, AttributeError):
            continue
        opened += 1
        with renderer:
            yield renderer
    if not opened:
        raise ContextError("no OpenGL could be opened; ssao-gl doctor says why")


def _named(only: Sequence[str], seed: int) -> list[Case]:
    """Cases by their names, all without any; random ones too. Raises SettingsError."""
    known = cases()
    found = []
    for name in only:
        digits = name.removeprefix(PREFIX)
        if name in known:
            found.append(known[name])
        elif name != digits and digits.isascii() and digits.isdigit():
            found.append(random_case(seed, int(digits[:18])))
        else:
            raise SettingsError(
                f"--only {name}: no such case; --list shows all, {PREFIX}N is a random one.{near_miss(name, known)}"
            )
    return found or list(known.values())


def _split(texts: Sequence[str]) -> list[str]:
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def _list(as_page: bool) -> None:
    if as_page:
        sys.stdout.write(case_table_markdown())
    else:
        print_table("Cases, each for every method", COLUMNS, rows(cases().values()))


def _replay(folder: Path, gl: str) -> int:
    with Renderer(gl, keep=KEEP) as renderer:
        row = replayed(renderer, folder)
        say(f"{row.case}, {row.method}, {row.provider}: {row.verdict}{f', {row.reason}' if row.reason else ''}")
    return int(row.verdict == FAIL)


def _show(provider: str, facts: str, results: StressResults) -> None:
    """One table a provider: cases down, methods across."""
    named = [row for row in results.named if row.provider == provider]
    if named:
        columns, lines = matrix(named)
        for start in range(1, len(columns), ACROSS):
            part = slice(start, start + ACROSS)
            print_table(f"{provider}: {facts}", [columns[0], *columns[part]], [[line[0], *line[part]] for line in lines])
    for method, preset, verdict, count in results.tallies(provider):
        say(f"{provider}, {count} random cases of {method} {preset}: {verdict}")


def _conclude(results: StressResults, facts: dict[str, str], output: Path | None) -> int:
    """Say what failed and how to replay it; the exit code."""
    for row in results.failed:
        measured = "" if row.measured is None else f", {row.measured:.3g} over {row.bound:.3g}"
        say(f"FAIL {row.case}, {row.method} {row.preset}, {row.provider}{measured}: {row.reason}\n     replay: {row.command}")
    if output is not None:
        save_stress_report(output, results, facts)
    say(", ".join(f"{count} {verdict}" for verdict, count in results.counts().items()))
    return int(bool(results.failed))
