"""The command line. Each command is a module; this one joins them and turns errors into one line and an exit code."""

from __future__ import annotations

import logging
import sys
import traceback
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter
from rich.console import Console

from ..errors import SsaoError
from .options import settings_help

EXIT_INTERRUPTED = 130

app = App(
    name="ssao-gl",
    help="Screen-space ambient occlusion on OpenGL ES. Without arguments: renders the embedded scene to ssao.png.",
    help_format="plaintext",
    result_action="return_value",
)
_COMMANDS = {
    "render": "ssao_gl.cli.render:render",
    "apply": "ssao_gl.cli.apply:apply",
    "compare": "ssao_gl.cli.compare:compare",
    "explain": "ssao_gl.cli.explain:explain",
    "methods": "ssao_gl.cli.explain:methods",
    "shader": "ssao_gl.cli.shader:shader",
    "doctor": "ssao_gl.cli.doctor:doctor",
    "truth": "ssao_gl.cli.truth:truth",
    "bench": "ssao_gl.cli.bench:bench",
}
for _name, _target in _COMMANDS.items():
    app.command(_target, name=_name, help_epilogue=settings_help() if _name in ("render", "apply", "explain") else None)


@app.default
def _embedded() -> int:
    from .render import embedded

    return embedded()


@app.meta.default
def _launch(
    *tokens: Annotated[str, Parameter(show=False, allow_leading_hyphen=True)],
    verbose: Annotated[
        bool, Parameter(name=["--verbose", "-v"], negative="", help="Log more; show tracebacks of errors.")
    ] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="", help="Print errors only.")] = False,
) -> int:
    """Global options, before or after the command."""
    logging.basicConfig(
        level=logging.DEBUG if verbose else logging.ERROR if quiet else logging.WARNING, format="ssao-gl: %(message)s"
    )
    for noisy in ("trimesh", "PIL"):
        logging.getLogger(noisy).setLevel(logging.INFO if verbose else logging.CRITICAL)
    from . import output

    output.QUIET.set(quiet)
    return app(tokens, exit_on_error=False, print_error=False) or 0


def main(arguments: list[str] | None = None) -> None:
    """Entry point of ``ssao-gl``: exits with 0, 1 (a comparison failed), 2 (bad input), 3 (no OpenGL) or 130 (Ctrl-C)."""
    tokens = sys.argv[1:] if arguments is None else arguments
    errors = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)
    try:
        code = app.meta(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    except KeyboardInterrupt:
        errors.print("ssao-gl: interrupted")
        code = EXIT_INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()  # the reader went away; there is nobody to tell
        code = 0
    except CycloptsError as error:
        errors.print(f"ssao-gl: {' '.join(str(error).split())}  (ssao-gl -h lists what there is)")
        code = 2
    except SsaoError as error:
        if "-v" in tokens or "--verbose" in tokens:
            traceback.print_exc()
        errors.print(f"ssao-gl: {error}")
        code = error.exit_code
    except MemoryError:
        errors.print("ssao-gl: out of memory; try a smaller --size or a smaller scene")
        code = 2
    sys.exit(code)
