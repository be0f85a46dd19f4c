"""The command line, run in this process."""

from __future__ import annotations

import pytest

from ssao_gl.cli import main


def run(*arguments: object, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of the command line, in this process."""
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    code = ended.value.code
    return (code if isinstance(code, int) else 0), out, err


def refused(capsys: pytest.CaptureFixture[str], *arguments: object, code: int = 2) -> str:
    """The one line of a command that must fail."""
    found, out, err = run(*arguments, capsys=capsys)
    assert found == code, (found, out, err)
    assert err.startswith("ssao-gl: ") and err.count("\n") == 1, err
    assert "unforeseen" not in err and "Traceback" not in err, err
    assert len(err) < 1000
    return err
