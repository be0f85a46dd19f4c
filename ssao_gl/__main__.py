"""``ssao-gl`` and ``python -m ssao_gl``: the command line, which may be interrupted while it is still being imported."""

import signal


def main() -> None:
    """Entry point; see :func:`ssao_gl.cli.main`."""
    heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # a shell's background jobs ignore it
    if heeded:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # an exception here would show a traceback of half-made modules
    from .cli import main as run

    if heeded:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run()


if __name__ == "__main__":
    main()
