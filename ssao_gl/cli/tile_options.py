"""Pictures in tiles, from the command line; and the line that says what was rendered."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..render.renderer import Renderer
from ..tiling.job import Job, draw
from .help_pages import RARE
from .output import progress, say
from .signals import Terminated
from .tokens import WHOLE

TileOption = Annotated[
    int | None,
    WHOLE,
    Parameter(
        name="--tile",
        group=RARE,
        allow_leading_hyphen=True,
        help="Draw in tiles of this many pixels a side, straight to the files; the same command goes on where it was interrupted."
        " There are no times of passes then. [default: by itself when the picture is larger than the driver's textures or takes over"
        " 2 GiB of them]",
    ),
]


def draw_tiles(renderer: Renderer, job: Job) -> Mapping[str, Any]:
    """Draw a picture in tiles with a progress bar, and say so. Gives the report."""
    log = logging.getLogger("ssao_gl")
    if job.layout.halo < job.layout.wanted:
        log.warning("tiles: %s", job.layout.describe())
    try:
        paths, report = draw(renderer, job, progress)
    except (KeyboardInterrupt, Terminated) as error:
        if job.folder.exists():
            error.add_note(f"the tiles so far are kept in {job.folder}; the same command goes on from there")
        raise
    say(rendered_line(job.output, paths, report))
    return report


def rendered_line(output: Path, paths: Sequence[Path], report: Mapping[str, Any]) -> str:
    """Return what was rendered into which files, on one line."""
    where = str(paths[0]) if len(paths) == 1 else f"{output}{'' if str(output).endswith('/') else '/'} ({len(paths)} files)"
    settings, seconds, tiles = report["settings"], report["seconds"], report.get("tiles")
    pieces = f" in {tiles['columns']}x{tiles['rows']} tiles" if tiles else ""
    if tiles and tiles["from_before"]:
        pieces += f" ({tiles['from_before']} from before)"
    rays = f", {settings['rays']:g} rays a pixel" if "rays" in settings else ""
    return (
        f"{where}: {report['scene']}, {report['contents']}, {report['size'][0]}x{report['size'][1]}{pieces},"
        f" {settings['method']} radius {settings[settings['method']]['radius']:.4g}, blur {settings['blur']}{rays}, {report['provider']}"
        f" ({report['renderer']}), {f'{1e3 * seconds:.0f} ms' if seconds < 100 else f'{seconds:.0f} s'}"
    )
