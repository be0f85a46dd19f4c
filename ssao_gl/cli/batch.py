"""``ssao-gl batch``: many views of many scenes."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..batch.local import cores
from ..batch.outputs import STORES, place_of
from ..batch.request import FORMATS, NAMES, Request
from ..batch.results import Results
from ..batch.run import rows_of, run
from ..batch.views import Around
from ..errors import SettingsError
from ..pipeline.outputs import AOVS
from .batch_progress import KINDS, Progress
from .help_pages import OUTPUT, RARE, VIEW
from .options import GlOption, LookOptions
from .output import comma_list, parse_size, say
from .signals import Terminated
from .tokens import WHOLE, parse_share

MOST_TOLD = 10
"""Different errors that are told of; the table has all."""


@Parameter(name="*", group=VIEW)
@dataclass(frozen=True, kw_only=True)
class CameraOptions:
    """Which views of each scene are drawn."""

    cameras: Annotated[
        str | None,
        Parameter(
            help="FILE, FILE:NAME or FILE:all, orbit:N, sphere:N, path:FILE[:N], or own (all of the scene file). [default: one, the scene's own or automatic]"
        ),
    ] = None
    size: Annotated[str, Parameter(help="Width x height, pixels.")] = "1280x720"
    distance: Annotated[
        float, Parameter(group=RARE, help="Of orbit and sphere, as a multiple of that from which the whole scene is seen.")
    ] = 1.0
    keep_away: Annotated[
        str, Parameter(group=RARE, help="Least distance of their eyes from surfaces, as a share of the scene's size.")
    ] = "1%"
    seed: Annotated[int, WHOLE, Parameter(group=RARE, help="Of their pattern.")] = 0

    def around(self) -> Around:
        """Return how generators look at a scene. Raises SettingsError."""
        share = 0.0 if self.keep_away in ("0", "0%") else parse_share(self.keep_away)
        if share is None:
            raise SettingsError(f"--keep-away {self.keep_away}: must be a share of the scene's size, like 2%")
        return Around(self.distance, share, self.seed)


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class PlaceOptions:
    """What is written, and where."""

    output: Annotated[
        str,
        Parameter(
            name=["--output", "-o"],
            help=f"Folder, URL of an object store, or one store by suffix: {', '.join(STORES)}.",
        ),
    ] = "batch"
    aov: Annotated[str, Parameter(help=f"What to write, by commas: {', '.join(AOVS)}.")] = "image,visibility"
    format: Annotated[
        tuple[str, ...],
        Parameter(negative="", help=f"Files: {', '.join(FORMATS)}, by commas. auto: PNG for colours, NPY for all else."),
    ] = ("auto",)
    names: Annotated[
        str, Parameter(group=RARE, help="Of files, without suffix: text with {scene}, {camera}, {aov}, {index}, {number}.")
    ] = NAMES


def batch(
    *scenes: str,
    manifest: Annotated[
        Path | None,
        Parameter(help="JSONL, CSV or Parquet file with a scene and its own cameras, size and settings in each row."),
    ] = None,
    view: CameraOptions = CameraOptions(),
    to: PlaceOptions = PlaceOptions(),
    workers: Annotated[
        int | None, WHOLE, Parameter(help="Processes of this machine; 0: this one itself. [default: one for each core]")
    ] = None,
    dask: Annotated[
        str | None, Parameter(help="Draw on a Dask cluster: address of its scheduler, as tcp://host:8786, or local:N.")
    ] = None,
    progress: Annotated[
        str,
        Parameter(
            group=OUTPUT, help=f"{', '.join(KINDS)}; auto: a bar on a terminal, lines elsewhere; json: on standard output."
        ),
    ] = "auto",
    gl: GlOption = "auto",
    look: LookOptions = LookOptions(),
) -> int:
    """Draw many views of many scenes, by several processes or a cluster.

    Parameters
    ----------
    scenes
        Scene files, or patterns in quotes, like 'models/**/*.glb'.
    """
    request = Request(
        cameras=view.cameras,
        size=parse_size(view.size),
        settings=look.settings(),
        share=parse_share(look.radius or ""),
        aovs=to.aov,
        formats=tuple(comma_list(to.format)),
        names=to.names,
        around=view.around(),
        provider=gl,
    )
    rows = rows_of(scenes, manifest, request)
    count = workers if workers is not None else 0 if dask is not None or "memory://" in to.output else cores()
    with Progress(progress) as shown:
        try:
            results = run(
                rows, place_of(to.output), to.output, gl, workers=count, dask=dask, begin=shown.begin, track=shown.track
            )
        except (KeyboardInterrupt, Terminated) as error:
            error.add_note("what is drawn so far is kept; the same command goes on from there")
            raise
        shown.end(results)
    look.dump(request.settings)
    if progress != "json":
        _tell(results, named=not shown.names_failures)
    return 1 if results.failed else 0


def _tell(results: Results, *, named: bool) -> None:
    log = logging.getLogger("ssao_gl")
    for warning in dict.fromkeys(text for row in results.rows for text in row.get("warnings", ())):
        log.warning("%s", warning)
    causes = {row["error"]: row for row in reversed(results.failed)}
    for row in list(reversed(causes.values()))[:MOST_TOLD] if named else ():
        log.error("%s: %s", row["name"], row["error"])
    whole = len(results.rows)
    speed = f", {results.drawn / results.seconds:.1f} views/s" if results.drawn else ""
    before = f" ({results.before} from before)" if results.before else ""
    failed = f"; {len(results.failed)} failed, and are tried again by the same command" if results.failed else ""
    say(f"{results.output}: {whole - len(results.failed)} of {whole} views{before} in {results.seconds:.1f} s{speed}{failed}")
