"""Sequences of frames: what is averaged, what begins anew, what goes on, and that nothing of it is there when nobody asks."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.graph.names import HISTORY
from ssao_gl.passes.temporal import Moment
from ssao_gl.pipeline.build import plan_apply, plan_render
from ssao_gl.render.accumulate import accumulated
from ssao_gl.render.history import History
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.lens import ShiftedLens
from ssao_gl.scene.model import Scene
from ssao_gl.tiling.turntable import Turntable, draw_turntable

from ..command_line import refused, run
from ..shapes import camera, plane, quad

SIZE = (96, 72)
NOISY = ao.Settings(method=ao.Bitmask(radius=0.7, scale=1, slices=1, steps=2, guard=0.0), blur=None)
SMALL = ao.Settings(method=ao.Bitmask(radius=0.7, scale=4, slices=1, steps=2, guard=0.0))
BOTH = pytest.mark.parametrize("settings", [NOISY, SMALL], ids=["full size", "small"])


def frame(
    renderer: ao.Renderer, scene: Scene, cam: Camera, history: History | None, settings: ao.Settings = NOISY
) -> np.ndarray:
    return renderer.render(scene, cam, SIZE, settings, aovs="visibility", history=history, checked=True).visibility


def alone(number: int) -> History:
    """The place of a frame in a sequence, and nothing before it."""
    history = History()
    history.frame = number
    return history


def moved(cam: Camera, x: float) -> Camera:
    pose = np.array(cam.pose)
    pose[:3, 3] += pose[:3, 0] * x
    return dataclasses.replace(cam, pose=pose)


@BOTH
def test_a_camera_that_stands_gives_the_mean_of_its_frames(
    any_renderer: ao.Renderer, settings: ao.Settings, embedded: Scene
) -> None:
    """Of sixteen, whose noise takes every place; the first one is the frame by itself, byte for byte."""
    cam, history = embedded.cameras[0], History()
    found = [frame(any_renderer, embedded, cam, history, settings) for _ in range(16)]
    each = [frame(any_renderer, embedded, cam, alone(number), settings) for number in range(16)]
    rounded = 0 if settings is NOISY else 1e-3  # depth in packed texels
    assert (
        np.abs(found[0] - frame(any_renderer, embedded, cam, None, settings)).max() <= rounded and (found[0] == each[0]).all()
    )
    for count in (2, 7, 16):
        assert np.abs(found[count - 1] - np.mean(each[:count], 0)).max() <= 1 / 255
    assert np.mean([np.std(one) for one in np.stack(each)]) > 0.1 and np.std(each, 0).mean() > 0.02, "there is noise to average"


@BOTH
def test_a_plane_is_open_along_any_way(any_renderer: ao.Renderer, settings: ao.Settings) -> None:
    history, scene = History(), plane(1.0)
    for number in range(6):
        assert (frame(any_renderer, scene, moved(camera(), 0.3 * number), history, settings) == 1).all()


def test_it_is_the_surface_that_is_averaged(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """While the camera moves by parts of a pixel, visibility of what is seen varies less than a third as much."""
    cam = embedded.cameras[0]

    def sigma(history: History | None) -> float:
        still = []
        for number in range(32):  # a quarter of a pixel a frame
            seen = dataclasses.replace(cam, lens=ShiftedLens(cam.lens, (0.25 * number, 0.0)))
            image = frame(any_renderer, embedded, seen, history)
            if number >= 16 and number % 4 == 0:
                still.append(np.roll(image, -number // 4, 1)[:, :-8])
        return float(np.std(still, 0).mean())

    assert sigma(History()) <= sigma(None) / 3


@BOTH
def test_where_depth_changed_nothing_is_left_after_a_frame(any_renderer: ao.Renderer, settings: ao.Settings) -> None:
    """A sheet that goes away: what it hid is as in a new sequence at once, and what it darkened when the world is said to move."""
    wall = quad((0, 0, -5), (40, 0, 0), (0, 40, 0))
    both, empty = Scene([wall, quad((0, 0, -4.6), (0.6, 0, 0), (0, 0.6, 0))]), Scene([wall])
    history = History()
    for _ in range(8):
        before = frame(any_renderer, both, camera(), history, settings)
    depth = any_renderer.render(both, camera(), SIZE, settings, aovs="depth").depth
    history.moved = True
    after = frame(any_renderer, empty, camera(), history, settings)
    assert before.min() < 0.9 and (after[depth < 4.9] == 1).all() and (after == 1).all()


@BOTH
def test_what_was_hidden_has_no_past(any_renderer: ao.Renderer, settings: ao.Settings) -> None:
    """The ground that a sheet hid is open at once, though nobody says that the world moved: nothing around it has a say."""
    wall, history = quad((0, 0, -5), (40, 0, 0), (0, 40, 0)), History()
    both = Scene([wall, quad((0, 0, -4.6), (0.6, 0, 0), (0, 0.6, 0))])  # farther off than two of the larger texels

    def drawn(scene: Scene) -> ao.Picture:
        return any_renderer.render(scene, camera(), (288, 216), settings, aovs="visibility,depth", history=history)

    before = [drawn(both) for _ in range(8)][-1]
    after = drawn(Scene([wall])).visibility
    hidden = np.argwhere(before.depth < 4.9)
    (top, left), (bottom, right) = hidden.min(0) + 4, hidden.max(0) - 3  # texels at its border show the wall too
    assert before.visibility.min() < 0.9 and after[top:bottom, left:right].size > 100
    assert (after[top:bottom, left:right] == 1).all()


@BOTH
def test_a_cut_is_a_new_sequence(any_renderer: ao.Renderer, settings: ao.Settings, embedded: Scene) -> None:
    """Where nothing of the last frame is seen, all begins anew, though noise is in another phase."""
    cam, history = embedded.cameras[0], History()
    frame(any_renderer, embedded, cam, history, settings)
    away = moved(cam, 50.0)
    frame(any_renderer, embedded, away, history, settings)
    assert (
        frame(any_renderer, embedded, cam, history, settings) == frame(any_renderer, embedded, cam, alone(2), settings)
    ).all()


@BOTH
def test_history_is_the_only_state(any_renderer: ao.Renderer, settings: ao.Settings, embedded: Scene, tmp_path: Path) -> None:
    """The same way twice, and a way that is put away half way, give the same bytes."""
    ways = [moved(embedded.cameras[0], 0.02 * number) for number in range(4)]
    histories = History(), History()
    whole, again = ([frame(any_renderer, embedded, cam, history, settings) for cam in ways] for history in histories)
    first = History()
    for cam in ways[:2]:
        frame(any_renderer, embedded, cam, first, settings)
    first.save(tmp_path / "h.npz")
    frame(any_renderer, embedded, embedded.cameras[0], None, ao.Settings())  # and something else in between
    second = History.load(tmp_path / "h.npz")
    rest = [frame(any_renderer, embedded, cam, second, settings) for cam in ways[2:]]
    assert all((a == b).all() for a, b in zip(whole, again, strict=True)) and all(
        (a == b).all() for a, b in zip(whole[2:], rest, strict=True)
    )
    (tmp_path / "h.npz").write_bytes(b"no")
    with pytest.raises(ao.FormatError, match="not the history"):
        History.load(tmp_path / "h.npz")


class Cut(Exception):
    pass


@pytest.mark.parametrize("output", ["t", "t.webp"])
def test_a_turn_that_was_cut_goes_on_with_the_same_bytes(
    any_renderer: ao.Renderer, embedded: Scene, output: str, tmp_path: Path
) -> None:
    def job(folder: Path) -> Turntable:
        flight = tuple(moved(embedded.cameras[0], 0.02 * number) for number in range(5))
        folder.mkdir(exist_ok=True)
        return Turntable(
            scene=embedded, camera=flight[0], size=(32, 24), settings=NOISY, aovs=("image",), count=5, output=folder / output,
            flight=flight, averaged=True,
        )  # fmt: skip

    def cut(indices: range) -> Any:
        yield from indices[:2]
        raise Cut

    draw_turntable(any_renderer, job(tmp_path / "whole"))
    with pytest.raises(Cut):
        draw_turntable(any_renderer, job(tmp_path / "cut"), cut)
    assert draw_turntable(any_renderer, job(tmp_path / "cut")) == 2
    content = [
        {path.relative_to(tmp_path / name): path.read_bytes() for path in (tmp_path / name).rglob("*") if path.is_file()}
        for name in ("whole", "cut")
    ]
    assert content[0] == content[1] and len(content[0]) == (1 if output != "t" else 5)


def test_accumulation_is_the_mean_of_its_frames(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """One frame is the picture itself; depth stays that of the first; edges become smooth."""
    seen = []

    def draw(cam: Camera, aovs: Sequence[str], history: History) -> ao.Picture:
        made = any_renderer.render(embedded, cam, SIZE, NOISY, aovs=aovs, history=history)
        seen.append(made)
        return made

    cam = embedded.cameras[0]
    plain = any_renderer.render(embedded, cam, SIZE, NOISY, aovs="image,visibility,depth")
    single, many = (accumulated(draw, cam, "image,visibility,depth", count) for count in (1, 8))
    assert all((single.arrays[name] == plain.arrays[name]).all() for name in plain.arrays)
    assert (many.depth == plain.depth).all()
    assert np.abs(many.visibility - np.mean([one.visibility for one in seen[1:]], 0)).max() <= 1 / 255
    with pytest.raises(ao.SettingsError, match="1 to 1024"):
        accumulated(draw, cam, "image", 0)


def test_without_a_sequence_nothing_is_more() -> None:
    """No pass, no texture, no shader: the plans know nothing of it."""
    for plan in (plan_render(NOISY, SIZE), plan_apply(NOISY, SIZE)):
        assert "temporal" not in plan.describe() and "history" not in plan.describe() and not plan.history


@pytest.mark.parametrize(
    ("settings", "size"),
    [
        (NOISY, (96, 72)),
        (SMALL, (24, 18)),
        (dataclasses.replace(SMALL, rays=1.0), (96, 72)),
        (dataclasses.replace(SMALL, supersample=2), (48, 36)),
    ],
    ids=["full size", "small", "rays", "supersample"],
)  # fmt: skip
def test_it_is_averaged_where_it_is_drawn(settings: ao.Settings, size: tuple[int, int]) -> None:
    """At the size of occlusion, where nothing but upsampling follows."""
    assert plan_render(settings, SIZE, ("visibility",), moment=Moment(1)).size_of(HISTORY) == size


@pytest.mark.gl
def test_commands_of_many_frames(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    small = ("render", "--size", "32x24", "-o", tmp_path / "x")
    assert "add --turntable or --path" in refused(capsys, *small, "--temporal")
    assert "exclude each other" in refused(capsys, *small, "--turntable", 2, "--path", "c.json")
    assert "1 to 1024" in refused(capsys, "render", "--size", "32x24", "-o", tmp_path / "x.png", "--accumulate", 0)
    large = refused(capsys, "render", "--size", "40000x16", "-o", tmp_path / "x.png", "--accumulate", 2)
    assert "would be drawn in tiles" in large and not (tmp_path / "x.png").exists()
    flight = '{"cameras": [{"eye": [6, 5, 7], "target": [0, 0, 0], "yfov_deg": 40}, {"eye": [6.1, 5, 7], "target": [0, 0, 0], "yfov_deg": 40}]}'
    (tmp_path / "flight.json").write_text(flight)
    code, out, err = run(*small, "--path", tmp_path / "flight.json", "--temporal", capsys=capsys)
    assert code == 0 and "2 frames" in out, err
    assert sorted(path.name for path in (tmp_path / "x").iterdir() if not path.name.startswith(".lock")) == [
        "0000.png",
        "0001.png",
    ]
