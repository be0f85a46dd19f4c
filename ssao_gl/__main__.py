"""``ssao-gl`` and ``python -m ssao_gl``: the command line, which may be stopped while it is still being imported."""

import os
import signal

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


def main() -> None:
    """Entry point; see :func:`ssao_gl.cli.main`."""
    for number, default in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL)):
        if signal.getsignal(number) is default:  # a shell's background jobs ignore the first
            signal.signal(number, _leave_at_once)
    try:
        from .cli import main as run

        run()
    finally:
        for number in WORDS:
            if signal.getsignal(number) is _leave_at_once:  # all is done; Python restores the defaults while it tidies up
                signal.signal(number, signal.SIG_IGN)


def _leave_at_once(number: int, frame: object) -> None:
    """Before the command begins and after it: an exception would show half-made modules, or be swallowed by one of them."""
    os.write(2, f"ssao-gl: {WORDS[signal.Signals(number)]}\n".encode())
    os._exit(128 + number)


if __name__ == "__main__":
    main()
