"""The folder of what can be made again."""

from __future__ import annotations

import logging
import sys
from pathlib import Path

import pytest

from ssao_gl.io.cache import default_folder, prune, read_cached, write_cached


@pytest.mark.skipif(sys.platform != "linux", reason="the variable is that of freedesktop.org's systems")
def test_the_folder_is_the_platforms(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_folder() == tmp_path / "ssao_gl"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert default_folder() == Path.home() / ".cache" / "ssao_gl"


def test_what_is_written_is_read_and_damage_is_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "deep" / "a.txt"
    assert read_cached(path, Path.read_text) is None and not caplog.records
    write_cached(path, lambda temporary: temporary.write_text("kept") and None)
    assert read_cached(path, Path.read_text) == "kept" and [p.name for p in path.parent.iterdir()] == ["a.txt"]

    def broken(_: Path) -> str:
        raise RecursionError("nested brackets")

    with caplog.at_level(logging.WARNING):
        assert read_cached(path, broken) is None
    assert "a.txt is damaged (nested brackets); making it anew" in caplog.text


def test_a_folder_that_cannot_be_made_costs_a_warning(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "file").write_text("")
    with caplog.at_level(logging.WARNING):
        write_cached(tmp_path / "file" / "a.txt", lambda temporary: None)
    assert "going on without" in caplog.text


def test_the_cache_forgets_what_was_not_used_for_longest(tmp_path: Path) -> None:
    import os

    for age, name in enumerate(("truth-c.npz", "truth-b.npz", ".truth-a.x.npz", "truth-a.npz", "kept.txt")):
        (tmp_path / name).write_bytes(bytes(100))
        os.utime(tmp_path / name, (1000 - age, 1000 - age))
    prune(tmp_path, "truth", 250)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["kept.txt", "truth-b.npz", "truth-c.npz"]
