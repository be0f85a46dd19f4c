"""``ssao-gl planner``: fit the planner's table of errors and the method's shares to rays, and check how good plans are."""

from __future__ import annotations

import dataclasses
import json as jsonlib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from ..errors import SettingsError
from ..io.atomic import atomic_write, check_writable
from ..scene.projection import Size
from .options import GlOption
from .output import check_json, comma_list, parse_size, say, write_json

app = App(
    name="planner",
    help="Fit the planner's table of errors or the shares of veils, or check how good plans are.",
    show=False,
    help_epilogue="",
)


def _listed(text: str, *names: str) -> Parameter:
    return Parameter(name=list(names) or None, help=text, negative="", show_default=False)


@app.command(name="fit")
def fit_errors(
    *scenes: Path,
    output: Annotated[Path, Parameter(name=["--output", "-o"], help="JSON file for the table.")] = Path("errors.json"),
    size: Annotated[
        tuple[str, ...], _listed("WIDTHxHEIGHT, by commas or repeated. [default: 640x360,1280x720]", "--size")
    ] = (),
    rows: Annotated[
        Path | None, _listed("JSON file that keeps what is measured; the same command goes on from there.", "--rows")
    ] = None,
    gl: GlOption = "auto",
) -> int:
    """Fit the weights that predict errors, to every candidate in every view against rays.

    Parameters
    ----------
    scenes
        Scene files, at least two, each with cameras in NAME.cam.json beside it.
    """
    from ..planner.candidates import CANDIDATES
    from ..planner.measure import error_samples, error_table, held_out_lines, load_samples
    from ..render.renderer import Renderer

    sizes: Sequence[Size] = list(dict.fromkeys(map(parse_size, comma_list(size)))) or [(640, 360), (1280, 720)]
    if len(set(scenes)) < 2:
        raise SettingsError("planner fit: give at least two scene files; each is predicted by a fit to the others")
    kept = load_samples(rows) if rows else {}
    for path in (output, *([rows] if rows else [])):
        check_writable(path)
    with Renderer(gl, keep=2 * len(CANDIDATES)) as renderer:
        for label, some in error_samples(renderer, scenes, sizes, kept):
            kept[label] = some
            say(label)
            if rows:
                _write(rows, {name: [dataclasses.asdict(one) for one in every] for name, every in kept.items()}, None)
    samples = [one for every in kept.values() for one in every]
    _write(output, error_table(samples), 1)
    for line in (*held_out_lines(samples), str(output)):
        say(line)
    return 0


@app.command
def veil(
    *scenes: Path,
    output: Annotated[Path, Parameter(name=["--output", "-o"], help="JSON file for the shares.")] = Path("veil_fits.json"),
    size: Annotated[str, Parameter(help="Width x height, pixels.")] = "1280x720",
    gl: GlOption = "auto",
) -> int:
    """Fit the shares by which bitmasks take what no depth buffer shows for hidden, against rays.

    Parameters
    ----------
    scenes
        Scene files, at least two, each with cameras in NAME.cam.json beside it.
    """
    from ..planner.fit_veil import fit_veils
    from ..render.renderer import Renderer

    pixels = parse_size(size)
    if len(set(scenes)) < 2:
        raise SettingsError("planner veil: give at least two scene files; each is left out of a fit to the others")
    check_writable(output)
    with Renderer(gl) as renderer:
        fits = fit_veils(scenes, pixels, renderer, say)
    _write(output, fits, 1)
    for kind, fit in fits["fits"].items():
        say(f"{kind}: {fit}")
    say(str(output))
    return 0


@app.command
def check(
    *scenes: Path,
    size: Annotated[str, Parameter(help="Width x height, pixels.")] = "1280x720",
    json: Annotated[Path | None, _listed("Write every candidate of every view to this file; - prints them.", "--json")] = None,
    gl: GlOption = "auto",
) -> int:
    """Hold predicted times and errors of every candidate against what is measured, and choices against the best.

    Parameters
    ----------
    scenes
        Scene files, each with cameras in NAME.cam.json beside it.
    """
    from ..planner.check import Outcome, check_lines, outcomes, view_line
    from ..planner.measure import file_views
    from ..render.renderer import Renderer

    pixels = parse_size(size)
    if not scenes:
        raise SettingsError("planner check: give at least one scene file, with cameras in NAME.cam.json beside it")
    check_json(json)
    found: dict[str, Sequence[Outcome]] = {}
    with Renderer(gl, keep=2) as renderer:
        for scene, camera in file_views(scenes):
            some = outcomes(renderer, scene, camera, pixels)
            found[some[0].view] = some
            say(view_line(some))
    for line in check_lines(found):
        say(line)
    if json:
        write_json(json, [dataclasses.asdict(one) for every in found.values() for one in every])
    return 0


def _write(path: Path, content: object, indent: int | None) -> None:
    with atomic_write(path) as temporary:
        temporary.write_text(jsonlib.dumps(content, indent=indent) + "\n", "utf-8")
