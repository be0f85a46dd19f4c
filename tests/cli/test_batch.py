"""``ssao-gl batch``: what it says, and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ssao_gl.batch import cluster
from ssao_gl.batch.local import JobQueue

from ..batch.models import jobs, pyramid
from ..command_line import refused, run

SMALL = ("--size", "16x12", "--aov", "depth", "--workers", "0")


@pytest.mark.gl
def test_it_tells_machines_and_people(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, bad = pyramid(tmp_path / "a.obj"), tmp_path / "b.obj"
    words = ("batch", good, bad, "--cameras", "sphere:3", *SMALL, "-o", tmp_path / "o")
    code, out, err = run(*words, "--progress", "json", capsys=capsys)
    events = [json.loads(line) for line in out.splitlines()]
    assert code == 1 and err == ""
    assert [event["event"] for event in events] == ["begin", "failed", "view", "view", "view", "end"]
    assert events[1]["name"] == "b" and events[4]["done"] == events[4]["of"] == 3 and events[4]["remaining_s"] == 0
    code, out, err = run(*words, capsys=capsys)
    assert code == 1 and out.startswith(f"{tmp_path / 'o'}: 3 of 4 views (3 from before)") and "1 failed" in out
    assert err.count("no such file") == 1
    pyramid(bad)
    assert run(*words, capsys=capsys)[0] == 0
    code, out, err = run("-q", *words[:4], "sphere:2", *words[5:], capsys=capsys)
    assert (code, out, err) == (0, "", "")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--cameras", "orbit:0"), "orbit:36"),
        (("--keep-away", "much"), "like 2%"),
        (("--progress", "jsn"), "Did you mean 'json'"),
        (("--workers", "-1"), "workers"),
        (("--distance", "0"), "distance"),
        (("--format", "jpeg"), "format 'jpeg'"),
        (("--dask", "tcp://127.0.0.1:9"), "no scheduler answers"),
    ],
)
def test_mistakes_are_one_line(
    words: tuple[str, ...], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "ANSWER", 0.5)
    scene = pyramid(tmp_path / "a.obj")
    assert told in refused(capsys, "-q", "batch", scene, "-o", tmp_path / "o", *words)


def test_nothing_to_draw_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert "nothing to draw" in refused(capsys, "batch")


def test_jobs_go_to_who_has_their_scene(tmp_path: Path) -> None:
    a, b = pyramid(tmp_path / "a.obj"), pyramid(tmp_path / "b.obj", 2)
    queue = JobQueue(jobs(a, b, cameras="orbit:3"))
    first = queue.take(None, [])
    second = queue.take(None, [a])
    assert first is not None and second is not None and (first.scene, second.scene) == (a, b)
    assert [job.scene for _ in range(2) if (job := queue.take(b, [a]))] == [b, b]
    helped = queue.take(b, [a])
    assert helped is not None and helped.scene == a, "b is done: help with a"
    assert queue.again(helped) and not queue.again(helped), "a job that ends two processes is given up"
