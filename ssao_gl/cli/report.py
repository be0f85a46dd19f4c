"""``ssao-gl report``: error against time of every method, on your own scenes, cameras, sizes and driver."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter

from ..errors import FormatError, encodable
from ..experiment.culling_rules import MOST_VIEWS
from ..experiment.culling_savings import FRAMES
from ..experiment.estimators import RAYS, Rays, ScreenSpace
from ..experiment.residual import residual_rays_upon
from ..experiment.sweep import Sweep, SweepProgress, check_rounds, fitting_scenes, split_size
from ..experiment.variants import TRUTH, variants
from ..experiment.views import MeasuredView, SceneReading, views
from ..io.atomic import check_writable
from ..io.cache import default_folder
from ..render.renderer import Renderer
from ..sampling.falloff import Falloff
from ..scene.projection import Size
from ..truth import Tracing
from ..truth.settings import NORMALS
from .help_pages import GATE, OF_TRUTH, OUTPUT, SWEEP
from .options import GlOption
from .output import QUIET, comma_list, parse_size, say
from .signals import Terminated
from .tokens import WHOLE
from .volume_options import VoxelOptions

Listed = tuple[str, ...]


def _option(text: str, group: Group, *names: str) -> Parameter:
    return Parameter(name=list(names) or None, help=text, group=group, negative="", show_default=False)


@Parameter(name="*", group=SWEEP)
@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """What is measured, and where."""

    size: Annotated[Listed, _option("WIDTHxHEIGHT, by commas or repeated. [default: 1280x720]", SWEEP, "--size")] = ()
    methods: Annotated[
        Listed, _option(f"Methods by commas. [default: all but the exhaustive {TRUTH}]", SWEEP, "--methods")
    ] = ()
    presets: Annotated[Listed, _option("Presets by commas. [default: all that a method has]", SWEEP, "--presets")] = ()
    set: Annotated[
        Listed, _option("Values of a setting, method.setting=value,value,...; may be repeated.", SWEEP, "--set")
    ] = ()
    cameras: Annotated[
        Listed, _option("Names by commas, or all. [default: all of NAME.cam.json beside the scene]", SWEEP, "--cameras")
    ] = ()
    rounds: Annotated[int, WHOLE, Parameter(help="Interleaved rounds of timing.")] = 5
    fit: Annotated[
        str | None,
        _option("Scenes, by commas, on which the fitted track is fitted; none. [default: every second]", SWEEP, "--fit"),
    ] = None
    scaling: Annotated[bool, Parameter(negative="", help="Also time against pixels (0.06 to 8 million), taps and radius.")] = (
        False
    )
    rules: Annotated[
        bool | None,
        Parameter(
            show_default=False,
            help="Also draw with the rules of leaving out on and off: times, shares, differences. [default: for up to 6 views]",
        ),
    ] = None

    rays: Annotated[
        Listed,
        _option(
            "Also the methods corrected by so many rays a pixel: 1/4,1, or of a preset medium+1/4. [default: none]",
            SWEEP,
            "--rays",
        ),
    ] = ()
    voxels: VoxelOptions = VoxelOptions()

    def sizes(self) -> list[Size]:
        """Return (width, height) of all images, in pixels. Raises SettingsError."""
        return list(dict.fromkeys(parse_size(text) for text in comma_list(self.size))) or [(1280, 720)]

    def estimators(self) -> list[ScreenSpace]:
        """Return the methods under their presets or ranges. Raises SettingsError."""
        return variants(comma_list(self.methods), comma_list(self.presets), self.set)

    def views(self, scenes: Sequence[Path]) -> list[MeasuredView]:
        """Return the cameras of all scenes. Raises SceneError, SettingsError."""
        names = [name for name in comma_list(self.cameras) if name != "all"]
        return views(scenes, names, self.sizes(), SceneReading(volume=self.voxels.volume()))


@Parameter(name="*", group=OF_TRUTH)
@dataclass(frozen=True, kw_only=True)
class TruthOptions:
    """What it is measured against."""

    spp: Annotated[int, WHOLE, Parameter(help="Rays a pixel of the truth.")] = 256
    falloff: Annotated[str, Parameter(help=f"How a blocker counts with distance: {', '.join(Falloff)}.")] = Falloff.HARD.value
    normals: Annotated[str, Parameter(help=f"Hemisphere about which normal: {' or '.join(NORMALS)}.")] = NORMALS[0]
    cache: Annotated[
        Path | None, _option("Folder where traced truth is kept. [default: the user's cache folder]", OF_TRUTH, "--cache")
    ] = None
    no_reference: Annotated[
        bool,
        Parameter(negative="", help="No exhaustive reference, and so no split of the error (which needs a hard falloff)."),
    ] = False
    reference_size: Annotated[
        str | None,
        _option(
            "Size at which the error is split. [default: --size shrunk to 320x180 pixels' worth]", OF_TRUTH, "--reference-size"
        ),
    ] = None

    def tracing(self) -> Tracing:
        """Return the settings of the rays. Raises SettingsError."""
        return Tracing(falloff=self.falloff, normals=self.normals, spp=self.spp)

    def split(self, size: Size) -> Size | None:
        """Return the size at which errors are split, for images of ``size``; None: not at all."""
        if self.no_reference or self.falloff != Falloff.HARD:
            return None
        return parse_size(self.reference_size) if self.reference_size else split_size(size)


@Parameter(name="*", group=GATE)
@dataclass(frozen=True, kw_only=True)
class GateOptions:
    """Comparison with an earlier report."""

    compare: Annotated[
        Path | None,
        _option("An earlier results.json: what got better or worse. In place of scenes: a newer one.", GATE, "--compare"),
    ] = None
    max_regression: Annotated[
        float, Parameter(help="Exit with 1 when a mean RMSE grew by more than this share, beyond the noise.")
    ] = 0.02
    max_view_regression: Annotated[
        float | None,
        _option(
            "Exit with 1 when RMSE grew by more than this share in any single view. [default: no limit]",
            GATE,
            "--max-view-regression",
        ),
    ] = None
    max_slowdown: Annotated[
        float | None,
        _option("The same for times as multiples of the baseline. [default: no limit]", GATE, "--max-slowdown"),
    ] = None


def report(
    *scenes: Path,
    output: Annotated[Path, _option("Folder for the report. [default: report]", OUTPUT, "--output", "-o")] = Path("report"),
    latex: Annotated[bool, Parameter(group=OUTPUT, negative="", help="Write the tables in LaTeX, too: report.tex.")] = False,
    what: SweepOptions = SweepOptions(),
    against: TruthOptions = TruthOptions(),
    gate: GateOptions = GateOptions(),
    gl: GlOption = "auto",
) -> int:
    """Measure methods against ray-traced truth and against the clock. The same command goes on where it was cut.

    Parameters
    ----------
    scenes
        Scene files, with cameras in NAME.cam.json beside them. Without any: the embedded scene.
    """
    from ..experiment.environment import check_packages
    from ..experiment.results import load_results
    from ..report.write import write

    before = load_results(gate.compare) if gate.compare else None
    if before is not None and [path.suffix.lower() for path in scenes] == [".json"]:
        return _compare(before, load_results(scenes[0]), gate)
    methods, tracing, split = what.estimators(), against.tracing(), against.split(what.sizes()[0])
    check_rounds(what.rounds)
    check_writable(output, folder=True)
    check_packages()
    seen = what.views(scenes)
    sweep = Sweep(
        views=seen,
        methods=methods,
        others=(*map(Rays, RAYS), *residual_rays_upon(methods, comma_list(what.rays))),
        tracing=tracing,
        rounds=what.rounds,
        fit=fitting_scenes(what.fit, seen),
        split=split,
        scaling=what.scaling,
        rules=len(seen) <= MOST_VIEWS if what.rules is None else what.rules,
    )
    found = _measured(sweep, gl, output, _cache(against.cache, output))
    paths = write(found, output, paper=latex)
    say(
        f"{paths[0]}: {len(seen)} views, {len(methods)} variants; beside it {', '.join(path.name for path in paths[1 : 5 + latex])}, plots"
    )
    return _compare(before, found, gate) if before is not None else 0


def _measured(sweep: Sweep, gl: str, output: Path, cache: Path) -> dict[str, Any]:
    """Measure what the journal of ``output`` lacks of a sweep, and return all results."""
    from ..experiment.environment import machine, now
    from ..experiment.results import results
    from ..experiment.run import Run
    from ..io.fingerprint import code_fingerprint
    from ..io.journal import Journal

    with Renderer(gl, keep=len({one.family for one in sweep.methods}) + FRAMES) as renderer:
        facts = machine(renderer.ctx)
        with Journal(output, sweep.header(facts, code_fingerprint()), sweep.contents) as journal:
            with _bar() as progress:
                try:
                    Run(sweep, renderer, journal, output, cache, progress).measure()
                except (KeyboardInterrupt, Terminated) as error:
                    error.add_note("finished rows are kept; the same command goes on from there")
                    raise
            return results(sweep, journal, facts, now(), encodable(shlex.join(["ssao-gl", *sys.argv[1:]])))


def _compare(before: dict[str, object], after: dict[str, object], gate: GateOptions) -> int:
    from ..report.columns import text
    from ..report.compare import changes, regressions, unlike, view_changes, view_regressions
    from ..report.compare_tables import comparison_tables
    from .output import print_table

    views = view_changes(before, after)
    if not views:
        raise FormatError("the two reports share no view and variant; there is nothing to compare")
    found = changes(views)
    for table in comparison_tables(found, views):
        rows = [[text(cell, column.spec) for cell, column in zip(row, table.columns, strict=True)] for row in table.rows]
        print_table(f"{table.title}. {table.note}", [column.title for column in table.columns], rows)
    if differing := unlike(before, after):
        say(f"the two reports differ in {', '.join(differing)}, too; what changed may come from that")
    worse = [one.describe() for one in regressions(found, gate.max_regression, gate.max_slowdown)]
    worse += [one.describe() for one in view_regressions(views, gate.max_view_regression)]
    for change in worse:
        say(f"worse than the limit: {change}")
    return 1 if worse else 0


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
    """Show a progress bar with the time left, when standard error is a terminal."""
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
