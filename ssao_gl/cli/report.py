"""``ssao-gl report``: error against time of every method, on your own scenes, cameras, sizes and driver."""

from __future__ import annotations

import logging
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import FormatError, SettingsError
from ..experiment.sweep import Sweep, SweepProgress, fitting_scenes, split_size
from ..experiment.variants import TRUTH, variants
from ..experiment.views import views
from ..io.atomic import check_writable
from ..io.cache import default_folder
from ..render.renderer import Renderer
from ..sampling.falloff import Falloff
from ..scene.projection import Size
from ..truth import Tracing
from ..truth.settings import NORMALS
from .options import GlOption
from .output import QUIET, parse_size, say

Listed = tuple[str, ...]


def _option(text: str, group: str, *names: str) -> Parameter:
    return Parameter(name=list(names) or None, help=text, group=group, negative="", show_default=False)


def report(
    *scenes: Path,
    output: Annotated[Path, _option("Folder for the report. [default: report]", "Output", "--output", "-o")] = Path("report"),
    size: Annotated[Listed, _option("WIDTHxHEIGHT, by commas or repeated. [default: 1280x720]", "Sweep", "--size")] = (),
    methods: Annotated[
        Listed, _option(f"Methods by commas. [default: all but the exhaustive {TRUTH}]", "Sweep", "--methods")
    ] = (),
    presets: Annotated[Listed, _option("Presets by commas. [default: all that a method has]", "Sweep", "--presets")] = (),
    set: Annotated[
        Listed,
        _option("Values of a setting, method.setting=value,value,...; may be repeated.", "Sweep", "--set"),
    ] = (),
    cameras: Annotated[
        Listed, _option("Names by commas, or all. [default: all of NAME.cam.json beside the scene]", "Sweep", "--cameras")
    ] = (),
    spp: Annotated[int, Parameter(group="Truth", help="Rays a pixel of the truth.")] = 256,
    falloff: Annotated[
        str, Parameter(group="Truth", help=f"How a blocker counts with distance: {', '.join(Falloff)}.")
    ] = Falloff.HARD.value,
    normals: Annotated[str, Parameter(group="Truth", help=f"Hemisphere about which normal: {' or '.join(NORMALS)}.")] = NORMALS[
        0
    ],
    cache: Annotated[
        Path | None, _option("Folder where traced truth is kept. [default: the user's cache folder]", "Truth", "--cache")
    ] = None,
    rounds: Annotated[int, Parameter(group="Sweep", help="Interleaved rounds of timing.")] = 5,
    fit: Annotated[
        str | None,
        _option("Scenes, by commas, on which the fitted track is fitted; none. [default: every second]", "Sweep", "--fit"),
    ] = None,
    no_reference: Annotated[
        bool,
        Parameter(
            group="Truth",
            negative="",
            help="No exhaustive reference, and so no split of the error (which needs a hard falloff).",
        ),
    ] = False,
    reference_size: Annotated[
        str | None,
        _option(
            "Size at which the error is split. [default: --size shrunk to 320x180 pixels' worth]", "Truth", "--reference-size"
        ),
    ] = None,
    scaling: Annotated[
        bool, Parameter(group="Sweep", negative="", help="Also time against pixels (0.06 to 8 million), taps and radius.")
    ] = False,
    rules: Annotated[
        bool | None,
        Parameter(
            group="Sweep",
            show_default=False,
            help="Also draw with the rules of leaving out on and off: times, shares, differences. [default: for up to 6 views]",
        ),
    ] = None,
    compare: Annotated[
        Path | None,
        _option("An earlier results.json: what got better or worse. In place of scenes: a newer one.", "Gate", "--compare"),
    ] = None,
    max_regression: Annotated[
        float, Parameter(group="Gate", help="Exit with 1 when a mean RMSE grew by more than this share, beyond the noise.")
    ] = 0.02,
    max_slowdown: Annotated[
        float | None,
        _option("The same for times as multiples of the yardstick. [default: no limit]", "Gate", "--max-slowdown"),
    ] = None,
    gl: GlOption = "auto",
) -> int:
    """Measure methods against ray-traced truth and against the clock. The same command goes on where it was cut.

    Parameters
    ----------
    scenes
        Scene files, with cameras in NAME.cam.json beside them. Without any: the embedded scene.
    """
    from ..experiment.culling_rules import MOST_VIEWS
    from ..experiment.culling_savings import FRAMES
    from ..experiment.environment import check_packages, machine
    from ..experiment.results import load_results, results
    from ..io.fingerprint import code_fingerprint

    before = load_results(compare) if compare else None
    if before is not None and [path.suffix.lower() for path in scenes] == [".json"]:
        return _compare(before, load_results(scenes[0]), max_regression, max_slowdown)
    sizes = _sizes(size)
    chosen = variants(_listed(methods), _listed(presets), set)
    if rounds < 1:
        raise SettingsError(f"--rounds {rounds}: must be at least 1")
    tracing = Tracing(falloff=falloff, normals=normals, spp=spp)
    check_writable(output, folder=True)
    check_packages()
    seen = views(scenes, [name for name in _listed(cameras) if name != "all"], sizes)
    sweep = Sweep(
        views=seen,
        variants=chosen,
        tracing=tracing,
        rounds=rounds,
        fit=fitting_scenes(fit, seen),
        split=_split_size(reference_size, sizes[0]) if falloff == Falloff.HARD and not no_reference else None,
        scaling=scaling,
        rules=len(seen) <= MOST_VIEWS if rules is None else rules,
    )
    from ..experiment.environment import now
    from ..experiment.run import Run
    from ..io.journal import Journal
    from ..report.write import write

    with Renderer(gl, keep=len({variant.method for variant in chosen}) + FRAMES) as renderer:
        facts = machine(renderer.ctx)
        with Journal(output, sweep.header(facts, code_fingerprint()), sweep.contents) as journal:
            with _bar() as progress:
                try:
                    Run(sweep, renderer, journal, output, _cache(cache, output), progress).measure()
                except KeyboardInterrupt:
                    logging.getLogger("ssao_gl").warning("finished rows are kept; the same command goes on from there")
                    raise
            found = results(sweep, journal, facts, now(), shlex.join(["ssao-gl", *sys.argv[1:]]))
    paths = write(found, output)
    say(
        f"{paths[0]}: {len(seen)} views, {len(chosen)} variants; beside it {', '.join(path.name for path in paths[1:4])}, plots"
    )
    return _compare(before, found, max_regression, max_slowdown) if before is not None else 0


def _compare(before: dict[str, object], after: dict[str, object], max_regression: float, max_slowdown: float | None) -> int:
    from ..report.compare import changes, regressions
    from .output import print_table

    found = changes(before, after)
    if not found:
        raise FormatError("the two reports share no view and variant; there is nothing to compare")
    columns = ("variant", "what", "views", "before", "after", "change", "95 % of resamplings", "verdict")
    print_table("Change between the reports, paired over views", columns, [change.cells() for change in found])
    worse = regressions(found, max_regression, max_slowdown)
    for change in worse:
        say(f"worse than the limit: {change.describe()}")
    return 1 if worse else 0


def _listed(texts: Sequence[str]) -> list[str]:
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def _sizes(texts: Sequence[str]) -> list[Size]:
    return list(dict.fromkeys(parse_size(text) for text in _listed(texts))) or [(1280, 720)]


def _split_size(given: str | None, size: Size) -> Size:
    return parse_size(given) if given else split_size(size)


def _cache(given: Path | None, output: Path) -> Path:
    """Where truth is kept: as asked, the user's own folder, or, if that cannot be written, the report's."""
    folder = given or default_folder()
    try:
        check_writable(folder, folder=True)
    except FormatError:
        if given is not None:
            raise
        return output / "truth"
    return folder


@contextmanager
def _bar() -> Iterator[SweepProgress]:
    """A progress bar with the time left, when standard error is a terminal."""
    if QUIET.get() or not sys.stderr.isatty():
        yield lambda title, done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description:40}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=Console(stderr=True), transient=True, speed_estimate_period=600) as bar:
        task = bar.add_task("report", total=None)
        yield lambda title, done, total: bar.update(task, description=title, completed=done, total=total)
