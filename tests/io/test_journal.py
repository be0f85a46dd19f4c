"""What is on disk survives kills and damage, and is never mixed up."""

from __future__ import annotations

import json
import logging
from pathlib import Path

import pytest

from ssao_gl.errors import FormatError
from ssao_gl.io.journal import NAME, Journal

HEADER = {"code": "1", "size": (2, 3)}
SEEN = {"v": "hash"}


def filled(folder: Path, count: int = 3) -> Path:
    with Journal(folder, HEADER, SEEN) as journal:
        for i in range(count):
            journal.add("shipped", "v", f"m{i}", value=i * 0.1)
    return folder / NAME


def kept(folder: Path, header: dict[str, object] = HEADER, seen: dict[str, str] = SEEN) -> list[float]:
    with Journal(folder, header, seen) as journal:
        return [row["value"] for row in journal.rows("shipped")]


def test_rows_come_back(tmp_path: Path) -> None:
    filled(tmp_path)
    with Journal(tmp_path, HEADER, SEEN) as journal:
        row = journal.find("shipped", "v", "m2")
        assert row is not None and row["value"] == pytest.approx(0.2)
        assert journal.find("shipped", "v", "m9") is None
        journal.add("shipped", "v", "m2", value=5.0)
    assert kept(tmp_path) == [0.0, 0.1, 5.0]  # the later row counts


def test_a_torn_last_line_is_cut_in_silence(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = filled(tmp_path)
    whole = path.read_bytes()
    for cut in (2, 20, 60):
        path.write_bytes(whole[:-cut])
        assert len(kept(tmp_path)) == 2
    assert not caplog.records and not list(tmp_path.glob("*damaged*"))


@pytest.mark.parametrize("line", range(4))
def test_damage_is_reported_and_the_file_kept(tmp_path: Path, line: int, caplog: pytest.LogCaptureFixture) -> None:
    path = filled(tmp_path)
    lines = path.read_bytes().splitlines(keepends=True)
    lines[line] = lines[line].replace(b"1", b"7").replace(b'"v"', b'"u"')
    path.write_bytes(b"".join(lines))
    with caplog.at_level(logging.WARNING):
        assert len(kept(tmp_path)) == (0 if line == 0 else 2)  # without its header a journal means nothing
    assert "1 damaged lines" in caplog.text
    assert (tmp_path / "journal.damaged-1.jsonl").read_bytes() == b"".join(lines)


def test_garbage_is_moved_aside(tmp_path: Path) -> None:
    (tmp_path / NAME).write_bytes(b"\x00\xff not a journal\n" * 3)
    assert kept(tmp_path) == []
    assert len(list(tmp_path.glob("journal.damaged-*"))) == 1


def test_another_header_starts_anew_and_loses_nothing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    before = filled(tmp_path).read_bytes()
    assert kept(tmp_path, {**HEADER, "code": "2"}) == []
    assert "other code" in caplog.text and (tmp_path / "journal.other-1.jsonl").read_bytes() == before


def test_rows_of_a_scene_that_has_changed_are_passed_over(tmp_path: Path) -> None:
    filled(tmp_path)
    assert kept(tmp_path, seen={"v": "other"}) == []
    assert len(kept(tmp_path)) == 3  # and come back when it changes back


def test_two_at_once_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("fcntl")
    with Journal(tmp_path, HEADER, SEEN), pytest.raises(FormatError, match="another run is writing there now"):
        Journal(tmp_path, HEADER, SEEN)


def test_lines_are_json(tmp_path: Path) -> None:
    for line in filled(tmp_path).read_text().splitlines():
        assert set(json.loads(line)) == {"crc", "row"}


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(FormatError, match="file"):
        Journal(tmp_path / "file", HEADER, SEEN)
