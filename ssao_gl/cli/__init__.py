"""The command line. Each command is a module; this one joins them and turns errors into one line and an exit code."""

from __future__ import annotations

import io
import logging
import os
import sys
import traceback
import warnings
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter

from ..errors import SsaoError
from . import signals
from .help_pages import ALL, COMMANDS, EXAMPLES, HELP_ALL, OF_METHODS
from .planner import app as planner
from .tokens import joined_numbers

EXIT_INTERRUPTED, EXIT_TERMINATED = 130, 143

app = App(
    name="ssao-gl",
    help="Screen-space ambient occlusion on OpenGL ES. Without arguments: renders the embedded scene to ssao.png.",
    help_format="plaintext",
    help_epilogue=EXAMPLES,
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
app.register_install_completion_command(help="Install completion of commands and options for your shell.")
app.meta.suppress_keyboard_interrupt = False
for _name, (_target, _help) in COMMANDS.items():
    app.command(
        _target, name=_name, help=_help, help_epilogue=OF_METHODS if _name in ("render", "apply", "explain", "bench") else ""
    )

app.command(planner)


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
    level = logging.DEBUG if verbose else logging.ERROR if quiet else logging.WARNING
    logging.basicConfig(level=level, format="ssao-gl: %(message)s", force=True)
    if not verbose:
        warnings.simplefilter("ignore")  # of Python, for developers
    for noisy in ("trimesh", "PIL"):
        logging.getLogger(noisy).setLevel(logging.INFO if verbose else logging.CRITICAL)
    from . import output

    output.QUIET.set(quiet)
    output.TAKEN.set("")
    with output.input_warnings(strict=False):
        return app(tokens, exit_on_error=False, print_error=False) or 0


def main(arguments: list[str] | None = None) -> None:
    """Entry point of ``ssao-gl``.

    Exits with 0, 1 (a comparison failed), 2 (bad input), 3 (no OpenGL), 130 (Ctrl-C) or 143 (SIGTERM).
    """
    tokens = joined_numbers(sys.argv[1:] if arguments is None else arguments)
    ALL.set(HELP_ALL in tokens)
    if tokens[:1] == ["help"]:
        tokens = [*tokens[1:2], "--help"]
    tokens = ["--help" if token == HELP_ALL else token for token in tokens]
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(
                errors="backslashreplace"
            )  # a terminal or pipe that cannot show a character is no reason to fail
    try:
        with signals.raised():
            if tokens and tokens[0] not in COMMANDS:
                from .mistakes import check_command

                check_command(tokens, (*COMMANDS, *planner.name))
            code = app.meta(tokens, exit_on_error=False, print_error=False, result_action="return_value")
            sys.stdout.flush()
    except BrokenPipeError:  # the reader went away; there is nobody to tell, now or when Python flushes at its end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    except (Exception, KeyboardInterrupt, signals.Terminated) as error:
        code, message = _verdict(error)
        message = "; ".join([message, *getattr(error, "__notes__", [])])
        if {"-v", "--verbose"} & set(tokens):
            traceback.print_exc()
        # What files and paths hold may try to steer the terminal.
        sys.stderr.write("ssao-gl: " + "".join(c if c.isprintable() or c == "\n" else "?" for c in message) + "\n")
    sys.exit(code)


def _verdict(error: BaseException) -> tuple[int, str]:
    """Exit code and one line for whatever ended a command."""
    match error:
        case SsaoError():
            return error.exit_code, str(error)
        case KeyboardInterrupt():
            return EXIT_INTERRUPTED, "interrupted"
        case signals.Terminated():
            return EXIT_TERMINATED, "terminated"
        case CycloptsError():
            from .mistakes import explained

            return 2, explained(error)
        case MemoryError():
            return 2, "out of memory; try a smaller --size or a smaller scene"
        case OSError():
            return 2, f"{error.filename or 'standard output'}: {error.strerror or error}"
    return 2, f"unforeseen {type(error).__name__}: {' '.join(str(error).split())[:200]}  (-v shows where; please report it)"
