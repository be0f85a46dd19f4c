"""Forks after a render: an answer or one ContextError that names 'spawn', and never a wait without end."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from ssao_gl.gl.process import SINGLE_THREADED

ROOT = Path(__file__).parents[2]
MESA = ("egl-es", "egl-gl", "osmesa")

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")


@pytest.fixture(params=["threads", "one thread"])
def environment(request: pytest.FixtureRequest) -> dict[str, str]:
    """Mesa as it comes, and Mesa told to draw in one thread, which the others know nothing of."""
    clean = {name: value for name, value in os.environ.items() if name != SINGLE_THREADED}
    return clean if request.param == "threads" else clean | {SINGLE_THREADED: "0"}


def lines(case: str, provider: str, environment: dict[str, str]) -> list[list[Any]]:
    command = [sys.executable, "-m", "tests.gl.process_cases", case, provider]
    done = subprocess.run(command, capture_output=True, text=True, timeout=400, env=environment, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def check(kind: str, answer: list[str], environment: dict[str, str], provider: str) -> None:
    """Right where Mesa draws in one thread, and so survives a fork; one ContextError elsewhere."""
    if SINGLE_THREADED in environment and provider in MESA:
        assert answer == ["right"], kind
    else:
        assert answer[0] == "ContextError" and "'spawn'" in answer[1] and "\n" not in answer[1], (kind, answer)


def test_a_new_an_inherited_and_a_closed_renderer(provider: str, environment: dict[str, str]) -> None:
    answers = {kind: answer for kind, *answer in lines("kinds", provider, environment)}
    assert answers["early"] == ["right"], "before its parent has drawn, a child may"
    assert answers.pop("parent") == ["right"], "the parent draws on"
    assert answers.pop("released") == ["right"], "a child may leave a with block"
    assert answers["closed"] == ["ContextError", "Renderer: was released; make another"], answers["closed"]
    for kind in ("new", "inherited"):
        check(kind, answers[kind], environment, provider)


@pytest.mark.parametrize(("case", "tasks"), [("pool", 4), ("prefetch", 8)])
def test_pools_and_data_loaders(case: str, tasks: int, provider: str, environment: dict[str, str]) -> None:
    answers = lines(case, provider, environment)
    assert len(answers) == tasks
    for kind, *answer in answers:
        check(kind, answer, environment, provider)


def test_a_pool_that_is_spawned_draws(provider: str) -> None:
    *pool, sent = lines("spawn", provider, dict(os.environ))
    assert pool == [["pool", "right"]] * 4
    assert sent == ["sent", "ContextError", "Renderer: cannot be sent to another process; make one there"]


def test_a_fork_while_another_thread_draws(provider: str, environment: dict[str, str]) -> None:
    answers = {kind: answer for kind, *answer in lines("busy", provider, environment)}
    assert answers["released"] == ["right"], "a child may let go of it"
    check("new", answers["new"], environment, provider)
    assert answers["inherited"][0] == "ContextError", answers["inherited"]
    assert re.search("'spawn'|while another thread drew", answers["inherited"][1])


def test_a_child_ends_as_programs_do(provider: str, environment: dict[str, str]) -> None:
    """OSMesa's exit handler used to wait for threads that a fork does not copy, or to crash."""
    assert lines("plain", provider, environment) == [["plain", "7"]]


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
def test_renderers_that_nobody_released_are_freed(provider: str) -> None:
    if provider not in (*MESA, "swiftshader"):
        pytest.skip("ANGLE itself keeps 36 MiB a context, however it is destroyed")
    ((_, full, left),) = lines("dropped", provider, dict(os.environ))
    assert left < 200, f"of {full:.0f} MiB, {left:.0f} are left"
