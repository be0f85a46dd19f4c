"""Output files: whole or not at all, whatever happens meanwhile, and nothing left beside them."""

from __future__ import annotations

import fcntl
import os
import signal
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.errors import FormatError
from ssao_gl.io.atomic import _temporary, atomic_write, check_writable, locked_folder, why_unreadable


def write(path: Path, content: bytes) -> None:
    with atomic_write(path) as temporary:
        temporary.write_bytes(content)


@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), ValueError("too large"), KeyboardInterrupt(), SystemExit(143)]
)
def test_an_older_file_stays_when_a_new_one_fails(error: BaseException, tmp_path: Path) -> None:
    target = tmp_path / "a.png"
    write(target, b"older")
    with (
        pytest.raises(FormatError if isinstance(error, OSError | ValueError) else type(error)),
        atomic_write(target) as temporary,
    ):
        temporary.write_bytes(b"half")
        raise error
    assert target.read_bytes() == b"older" and list(tmp_path.iterdir()) == [target]


def test_rights_are_those_of_any_new_file(tmp_path: Path) -> None:
    write(tmp_path / "a.png", b"x")
    (tmp_path / "b").write_bytes(b"x")
    assert (tmp_path / "a.png").stat().st_mode == (tmp_path / "b").stat().st_mode


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    for name in ("there.png", "new.png"):
        (tmp_path / name).symlink_to(f"far/{name}")
    (tmp_path / "far" / "there.png").write_bytes(b"older")
    for name in ("there.png", "new.png"):
        write(tmp_path / name, b"x")
        assert (tmp_path / "far" / name).read_bytes() == b"x" and (tmp_path / name).is_symlink()
    assert len(list(tmp_path.rglob("*"))) == 5, "nothing else stays"
    (tmp_path / "circle.png").symlink_to("circle.png")
    with pytest.raises(FormatError, match="symbolic links"):
        write(tmp_path / "circle.png", b"x")
    assert (tmp_path / "circle.png").is_symlink()


HALF = """
import sys, time
from pathlib import Path
from ssao_gl.io.atomic import atomic_write
with atomic_write(Path(sys.argv[1])) as temporary:
    temporary.write_bytes(b"half")
    print(flush=True)
    time.sleep(60)
"""


def test_what_a_killed_run_left_is_gone_after_the_next(tmp_path: Path) -> None:
    """And while it runs, another is told so."""
    target = tmp_path / "a.png"
    with subprocess.Popen([sys.executable, "-c", HALF, str(target)], stdout=subprocess.PIPE) as running:
        assert running.stdout is not None
        running.stdout.readline()
        with pytest.raises(FormatError, match=r"a\.png: another run is writing there now"):
            write(target, b"second")
        assert not target.exists()
        running.send_signal(signal.SIGKILL)
    assert [path.name for path in tmp_path.iterdir()] == [".a.part.png"], "all that a kill leaves"
    write(target, b"third")
    assert target.read_bytes() == b"third" and list(tmp_path.iterdir()) == [target]


def test_names_of_outputs_do_not_meet(tmp_path: Path) -> None:
    """Outputs of the same folder are written at the same time."""
    names = ["a.png", "a.npy", "a.b.png", "b.png", "a", "x" * 200 + ".png", "x" * 201 + ".png", "\u00e9" * 120 + ".png"]
    with atomic_write(tmp_path / "a.part.png") as outer:
        outer.write_bytes(b"outer")
        for name in names:
            write(tmp_path / name, name.encode())
    assert len(list(tmp_path.iterdir())) == len(names) + 1
    assert all((tmp_path / name).read_bytes() == name.encode() for name in names)


@given(
    st.sets(
        st.text(st.characters(exclude_characters="/\0", codec="utf-8"), min_size=1).filter(lambda n: n not in (".", "..")),
        min_size=2,
    )
)
def test_temporary_names_are_hidden_short_and_unlike(names: set[str]) -> None:
    made = {name: _temporary(Path("folder") / name) for name in names}
    for name, temporary in made.items():
        assert (
            temporary.parent == Path("folder") and temporary.name.startswith(".") and temporary.name.endswith(Path(name).suffix)
        )
        assert len(os.fsencode(temporary.name)) <= max(255, len(os.fsencode(Path(name).suffix)) + 120)
    assert len(set(made.values())) == len({(Path(n).stem, Path(n).suffix) for n in names})


def test_a_link_laid_where_we_write_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "far").write_bytes(b"far")
    (tmp_path / ".a.part.png").symlink_to("far")
    with pytest.raises(FormatError, match="cannot write"):
        write(tmp_path / "a.png", b"x")
    os.link(tmp_path / "far", tmp_path / ".b.part.png")
    write(tmp_path / "b.png", b"x")
    assert (tmp_path / "far").read_bytes() == b"far" and (tmp_path / "b.png").read_bytes() == b"x"


def test_where_files_cannot_be_locked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", fail)
    with atomic_write(tmp_path / "a.png") as temporary:
        assert str(os.getpid()) in temporary.name
        temporary.write_bytes(b"x")
    with locked_folder(tmp_path):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_many_at_once(tmp_path: Path) -> None:
    """Each write succeeds or is refused; what is there is always whole, and nothing else stays."""
    target, verdicts = tmp_path / "a.bin", []

    def work(number: int) -> None:
        for _ in range(50):
            try:
                write(target, bytes([number]) * 100_000)
                verdicts.append("written")
            except FormatError as error:
                assert "another run is writing" in str(error)
                verdicts.append("refused")
            if target.exists():
                found = target.read_bytes()
                assert len(found) == 100_000 and len(set(found)) == 1

    workers = [threading.Thread(target=work, args=(number,)) for number in range(6)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(verdicts) == 300 and "written" in verdicts and list(tmp_path.iterdir()) == [target]


def test_a_folder_is_claimed_by_one_run(tmp_path: Path) -> None:
    with locked_folder(tmp_path):
        with pytest.raises(FormatError, match="another run is writing there now"), locked_folder(tmp_path):
            pass
        write(tmp_path / "a.png", b"x")
    with locked_folder(tmp_path):
        pass
    with pytest.raises(FormatError, match="cannot write"), locked_folder(tmp_path / "gone"):
        pass


def test_written_whole_or_not(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    with atomic_write(target) as temporary:
        temporary.write_text("one")
        assert not target.exists()
    assert target.read_text() == "one" and list(tmp_path.iterdir()) == [target]
    for error in (KeyboardInterrupt, RuntimeError, SystemExit):
        with pytest.raises(error), atomic_write(target) as temporary:
            temporary.write_text("half")
            raise error
        assert target.read_text() == "one" and list(tmp_path.iterdir()) == [target]


def test_mode_follows_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        with atomic_write(tmp_path / "a") as temporary:
            temporary.write_text("x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640


def test_check_writable_leaves_nothing(tmp_path: Path) -> None:
    check_writable(tmp_path / "a.png")
    check_writable(tmp_path / "x" / "y", folder=True)
    assert not list(tmp_path.iterdir())
    (tmp_path / "f").write_text("x")
    for path, folder, text in (
        (tmp_path / "gone" / "a.png", False, "there is no folder"),
        (tmp_path / "f" / "a.png", False, "is not a folder"),
        (tmp_path / "f" / "x", True, "is not a folder"),
        (tmp_path, False, "it is a folder"),
        (Path("/proc/a.png"), False, "cannot write /proc/a.png"),
    ):
        with pytest.raises(FormatError, match=text):
            check_writable(path, folder=folder)


def test_unreadable(tmp_path: Path) -> None:
    (tmp_path / "full").write_text("x")
    (tmp_path / "empty").write_text("")
    assert why_unreadable(tmp_path / "full") is None
    assert why_unreadable(tmp_path / "empty") == "the file is empty" and why_unreadable(tmp_path / "empty", empty=True) is None
    assert why_unreadable(tmp_path) == "is a folder"
    assert why_unreadable(tmp_path / "gone") == why_unreadable(tmp_path / "full" / "x") == "no such file"
    assert why_unreadable(Path("/dev/zero")) == "is not a regular file"
