"""What ``-h`` shows: a line for each command, and on a command's page what is often asked for; ``--help-all`` shows the rest."""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar
from typing import TYPE_CHECKING

from cyclopts import Group

if TYPE_CHECKING:
    from cyclopts.help import HelpPanel
    from rich.console import Console, ConsoleOptions

HELP_ALL = "--help-all"
ALL: ContextVar[bool] = ContextVar("help-all", default=False)

COMMANDS: Mapping[str, tuple[str, str]] = {
    "render": ("ssao_gl.cli.render:render", "Render a scene file with ambient occlusion."),
    "batch": (
        "ssao_gl.cli.batch:batch",
        "Draw many views of many scenes, by several processes or a cluster.\n\n"
        "The same command goes on where it was cut, and redoes what changed. Exits with 1 when views failed.",
    ),
    "sheet": (
        "ssao_gl.cli.sheet:sheet",
        "Draw many scenes into one picture with their names.\n\n"
        "A file that cannot be drawn gets a tile that says why, and a line on standard error; the exit code is then 1.",
    ),
    "apply": ("ssao_gl.cli.apply:apply", "Dim a picture by the occlusion of its depth."),
    "compare": ("ssao_gl.cli.compare:compare", "Compare two pictures or arrays; exit 1 when over a limit."),
    "methods": ("ssao_gl.cli.methods:methods", "List methods and filters; with a NAME its settings, ranges and defaults."),
    "explain": (
        "ssao_gl.cli.explain:explain",
        "Print the plan of a render: passes, memory, and what was left out and why.\n\n"
        "Draws nothing without --measure, --budget-ms or --max-error; the last two also list everything that was considered.",
    ),
    "truth": (
        "ssao_gl.cli.truth:truth",
        "Trace ambient occlusion by rays, to measure others by.\n\nThe same command goes on where Ctrl-C cut it.",
    ),
    "bake": (
        "ssao_gl.cli.bake:bake",
        "Trace ambient occlusion into the vertices or textures of a GLB file.\n\n"
        "No OpenGL is needed. The same command goes on where Ctrl-C cut it.",
    ),
    "report": (
        "ssao_gl.cli.report:report",
        "Measure methods against ray-traced truth and against the clock.\n\nThe same command goes on where it was cut.",
    ),
    "bench": ("ssao_gl.cli.bench:bench", "Time every pass on this driver, as ratios."),
    "stress": (
        "ssao_gl.cli.stress:stress",
        "Try every method on extreme, broken and random input.\n\n"
        "Checks what every picture promises. Exits with 1 when a case fails; its input is then written to a folder, as small"
        " as it gets, with the command that replays it.",
    ),
    "export": (
        "ssao_gl.cli.export:export",
        "Write the pipeline of apply for WebGL2, for native GLES 3, or as JSON.\n\nOne export serves every canvas size and projection.",
    ),
    "view": (
        "ssao_gl.cli.view:view",
        "Write one HTML file that shows a scene in the browser.\n\nOrbit, methods, presets, before and after, buffers, and rays beside it; it needs no network.",
    ),
    "shader": ("ssao_gl.cli.shader:shader", "Print a shader, complete for one GLSL dialect."),
    "doctor": ("ssao_gl.cli.doctor:doctor", "Say which OpenGL there is, and the cure where there is none."),
}
"""Command -> where it is, and what its help says; one line of it stands in the list of commands."""

EXAMPLES = """\
Examples:
  ssao-gl render model.glb -o out.png
  ssao-gl render part.stl --method gtao --radius 5% --size 1920x1080 -o part.png
  ssao-gl apply photo.png --depth depth.npy --yfov-deg 60 -o shaded.png

ssao-gl COMMAND -h shows the options of a command."""

OF_METHODS = "Settings of a method, for --set and TOML: ssao-gl methods NAME, as alchemy."


def _folded(console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
    """Print the panel whole when all is asked for, else the names that are in it."""
    if ALL.get():
        from cyclopts.help import DefaultFormatter

        DefaultFormatter()(console, options, panel)
    elif panel.entries:
        names = ", ".join(entry.positive_names[-1] for entry in panel.entries)
        console.print(f"{panel.title} ({HELP_ALL} describes them): {names}", markup=False, highlight=False)


SWEEP, OF_TRUTH, GATE = (Group.create_ordered(name) for name in ("Sweep", "Truth", "Gate"))
OCCLUSION, RAYS, VIEW, OUTPUT = (Group.create_ordered(name) for name in ("Occlusion", "Rays", "View", "Output"))
"""Groups of options, in the order of the page."""
RARE = Group.create_ordered("More options", help_formatter=_folded)
"""Options that few need."""
