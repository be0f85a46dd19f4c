"""What is written to and never replaced, and what is refused."""

from __future__ import annotations

import os
import socket
import stat
import sys
from pathlib import Path

import pytest

from ssao_gl.errors import FormatError
from ssao_gl.io import streams
from ssao_gl.io.atomic import atomic_write, check_writable

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="devices and pipes of POSIX")


def test_disks_and_sockets_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # the name of a socket is short
    with socket.socket(socket.AF_UNIX) as made:
        made.bind("s.png")
        with pytest.raises(FormatError, match=r"^cannot write s.png: it is a socket; expected a file$"):
            check_writable(Path("s.png"))
    try:
        os.mknod("d.png", stat.S_IFBLK | 0o600, os.makedev(7, 250))
    except PermissionError:
        pytest.skip("devices cannot be made here")
    with pytest.raises(FormatError, match="it is a block device"), atomic_write(Path("d.png")):
        pytest.fail("must not begin")
    assert stat.S_ISBLK(Path("d.png").lstat().st_mode)


def test_a_pipe_that_nobody_reads_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streams, "WAIT", 0.1)
    pipe = tmp_path / "p.png"
    os.mkfifo(pipe)
    with pytest.raises(FormatError, match="nothing reads from this pipe"), atomic_write(pipe) as temporary:
        temporary.write_bytes(b"x")
    assert pipe.is_fifo() and list(tmp_path.iterdir()) == [pipe]


def test_suffixes(tmp_path: Path) -> None:
    (tmp_path / "n").symlink_to(os.devnull)
    (tmp_path / "file").write_text("")
    assert streams.output_suffix(tmp_path / "n") == streams.output_suffix(streams.STDOUT) == ".png"
    assert streams.output_suffix(tmp_path / "a.NPY") == ".npy" and streams.output_suffix(tmp_path / "file") == ""


def test_links_in_a_circle(tmp_path: Path) -> None:
    (tmp_path / "a.png").symlink_to("b.png")
    (tmp_path / "b.png").symlink_to("a.png")
    for write in (check_writable, lambda path: atomic_write(path).__enter__()):
        with pytest.raises(FormatError, match="symbolic links"):
            write(tmp_path / "a.png")
    assert (tmp_path / "a.png").is_symlink()


def test_what_c_code_prints_is_not_shown(capfd: pytest.CaptureFixture[str]) -> None:
    os.write(1, b"before ")
    with pytest.raises(ValueError), streams.silenced():
        os.write(1, b"noise")
        os.write(2, b"noise")
        raise ValueError
    os.write(1, b"after")
    assert capfd.readouterr() == ("before after", "")
