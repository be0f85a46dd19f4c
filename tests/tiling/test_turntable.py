"""Turns about a scene: they go on where they were cut, and give what they give at once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import ssao_gl as ao
from ssao_gl.scene.model import Scene
from ssao_gl.tiling.turntable import STATE, Turntable, draw_turntable

pytestmark = pytest.mark.gl


class Cut(Exception):
    pass


def cut_after(count: int) -> object:
    def track(indices: range) -> Iterator[int]:
        yield from indices[:count]
        raise Cut

    return track


def turn(output: Path, scene: Scene, *aovs: str, count: int = 4) -> Turntable:
    camera = scene.default_camera((16, 12))
    return Turntable(
        scene=scene, camera=camera, size=(16, 12), settings=ao.Settings(), aovs=aovs or ("image",), count=count, output=output
    )


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(("output", "aovs"), [("t", ("image",)), ("t", ("image", "depth")), ("t.gif", ("image",))])
def test_it_goes_on_where_it_was_cut(
    output: str, aovs: tuple[str, ...], any_renderer: ao.Renderer, embedded: Scene, tmp_path: Path
) -> None:
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    whole.mkdir()
    broken.mkdir()
    assert draw_turntable(any_renderer, turn(whole / output, embedded, *aovs)) == 0
    job = turn(broken / output, embedded, *aovs)
    with pytest.raises(Cut):
        draw_turntable(any_renderer, job, cut_after(0))  # type: ignore[arg-type]
    assert not list(broken.iterdir()), "nothing was drawn"
    for _ in range(2):
        with pytest.raises(Cut):
            draw_turntable(any_renderer, job, cut_after(1))  # type: ignore[arg-type]
    assert job.kept.exists()
    assert draw_turntable(any_renderer, job) == 2
    assert content(broken) == content(whole) and not job.kept.exists()


def test_another_turn_begins_anew(any_renderer: ao.Renderer, embedded: Scene, tmp_path: Path) -> None:
    with pytest.raises(Cut):
        draw_turntable(any_renderer, turn(tmp_path / "t", embedded), cut_after(2))  # type: ignore[arg-type]
    assert draw_turntable(any_renderer, turn(tmp_path / "t", embedded, count=3)) == 0
    with pytest.raises(Cut):
        draw_turntable(any_renderer, turn(tmp_path / "t", embedded), cut_after(2))  # type: ignore[arg-type]
    (tmp_path / "t" / STATE).write_text("[" * 100_000)
    assert draw_turntable(any_renderer, turn(tmp_path / "t", embedded)) == 0
