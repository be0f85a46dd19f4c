"""Jobs of tiles, by Python and by the command line: what they write, and that interruptions lose nothing."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.io.images import load_image
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene
from ssao_gl.tiling.job import Job, draw
from ssao_gl.tiling.layout import layout

from ..command_line import refused, run
from ..contract.test_tiles import ALL, settings
from ..shapes import camera, plane

SMALL = (160, 100)


class Cut(Exception):
    """What interrupts a job here."""


def interrupted(after: int) -> Any:
    """Progress that ends the job when so many items are done."""

    def track(items: Iterable[Any], title: str, total: int) -> Iterator[Any]:
        for index, item in enumerate(items):
            if index == after:
                raise Cut
            yield item

    return track


def job(folder: Path, scene: Scene, output: str, aovs: tuple[str, ...], **changes: Any) -> Job:
    made, cam = settings("alchemy", ao.Joint()), scene.cameras[0]
    cut = layout(scene, cam, SMALL, made, aovs, tile=64)
    assert cut is not None
    every: dict[str, Any] = {"scene": scene, "camera": cam, "size": SMALL, "settings": made, "aovs": aovs, "layout": cut}
    return Job(**(every | {"output": folder / output} | changes))


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


OUTPUTS: dict[str, tuple[str, ...]] = {
    "v.png": ("visibility",), "i.png": ("image",), "d.png": ("depth",), "v.npy": ("visibility",), "v.exr": ("visibility",), "all": ALL,
}  # fmt: skip


@pytest.mark.parametrize("output", OUTPUTS)
def test_an_interrupted_job_goes_on(any_renderer: ao.Renderer, embedded: Scene, output: str, tmp_path: Path) -> None:
    """The same files as without the interruptions, and every tile drawn once."""
    straight, broken = tmp_path / "straight", tmp_path / "broken"
    for folder in (straight, broken):
        folder.mkdir()
    aovs = OUTPUTS[output]
    paths, report = draw(any_renderer, job(straight, embedded, output, aovs))
    assert sorted(content(straight)) == sorted(str(path.relative_to(straight)) for path in paths)
    assert report["tiles"]["count"] == 6 and report["tiles"]["from_before"] == 0 and report["size"] == list(SMALL)
    titles: list[tuple[str, int]] = []
    for after in (1, 2):
        with pytest.raises(Cut):
            draw(any_renderer, job(broken, embedded, output, aovs), interrupted(after))
        assert all(".tiles/" in name for name in content(broken)), "nothing half-written"
    _, report = draw(any_renderer, job(broken, embedded, output, aovs), lambda items, *what: (titles.append(what), items)[1])
    assert titles[0] == ("tiles", 3) and report["tiles"]["from_before"] == 3
    assert content(broken) == content(straight)


def test_an_interruption_while_writing_draws_nothing_again(any_renderer: ao.Renderer, embedded: Scene, tmp_path: Path) -> None:
    def track(items: Iterable[Any], title: str, total: int) -> Iterable[Any]:
        if title != "tiles":
            raise Cut
        return items

    with pytest.raises(Cut):
        draw(any_renderer, job(tmp_path, embedded, "all", ALL), track)
    _, report = draw(any_renderer, job(tmp_path, embedded, "all", ALL))
    assert report["tiles"]["from_before"] == 6 and len(content(tmp_path)) == 10


CHANGES: dict[str, Any] = {
    "settings": {"settings": settings("alchemy", ao.Joint(radius=3))},
    "bits": {"bits": 16},
    "scene": {"scene": plane()},
    "camera": {"camera": camera()},
}


@pytest.mark.parametrize("change", CHANGES)
def test_another_job_begins_anew(any_renderer: ao.Renderer, embedded: Scene, change: str, tmp_path: Path) -> None:
    with pytest.raises(Cut):
        draw(any_renderer, job(tmp_path, embedded, "v.png", ("visibility",)), interrupted(2))
    _, report = draw(any_renderer, dataclasses.replace(job(tmp_path, embedded, "v.png", ("visibility",)), **CHANGES[change]))
    assert report["tiles"]["from_before"] == 0
    assert list(content(tmp_path)) == ["v.png"]


def test_a_job_that_cannot_be_drawn_leaves_nothing(any_renderer: ao.Renderer, embedded: Scene, tmp_path: Path) -> None:
    parallel = Camera.orthographic(5.0, 0.0, 30.0, embedded.cameras[0].pose)
    for output in ("v.png", "folder"):
        made = job(tmp_path, embedded, output, ("visibility",), camera=parallel, settings=settings("lecture"))
        with pytest.raises(ao.SettingsError, match="perspective cameras only"):
            draw(any_renderer, made)
        assert list(tmp_path.iterdir()) == []


def test_exr_files_that_do_not_fit_into_memory_are_refused(any_renderer: ao.Renderer, embedded: Scene, tmp_path: Path) -> None:
    huge = job(tmp_path, embedded, "v.exr", ("normal",), size=(16384, 16384))
    with pytest.raises(ao.FormatError, match=r"would take 3.0 GiB \(at most 2\); use .npy or .png"):
        draw(any_renderer, huge)
    assert list(tmp_path.iterdir()) == []


# The command line


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """``ssao-gl render`` at a small size, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def render(*arguments: object) -> str:
        code, out, err = run("render", "--size", "160x100", *arguments, capsys=capsys)
        assert code == 0, err
        return out

    return render


@pytest.mark.gl
def test_the_command_line_writes_the_same_files(command: Any) -> None:
    out = command("-o", "tiles", "--aov", ",".join(ALL), "--tile", 64, "--json", "tiles.json", "--method", "alchemy")
    assert out.startswith("tiles/ (10 files): ") and "160x100 in 3x2 tiles" in out
    command("-o", "whole", "--aov", ",".join(ALL), "--method", "alchemy")
    report = json.loads(Path("tiles.json").read_text())
    assert report["tiles"]["count"] == 6 and report["tiles"]["side"] == [64, 64] and report["size"] == [160, 100]
    for name in ALL:
        a, b = np.load(f"tiles/{name}.npy"), np.load(f"whole/{name}.npy")
        assert a.dtype == b.dtype and a.shape == b.shape
        with Image.open(f"tiles/{name}.png") as tiles, Image.open(f"whole/{name}.png") as whole:
            assert tiles.info == whole.info and tiles.mode == whole.mode
            assert (np.abs(np.asarray(tiles).astype(int) - np.asarray(whole)) > 1).mean() < 1e-3
    assert sorted(path.name for path in Path().iterdir()) == ["tiles", "tiles.json", "whole"]


@pytest.mark.gl
def test_one_file_by_suffix_and_bits(command: Any) -> None:
    command("-o", "a.npy", "--tile", 64)
    command("-o", "a.png", "--tile", 64, "--aov", "visibility", "--bits", 16)
    with Image.open("a.png") as image:
        assert np.abs(np.asarray(image) / 65535 - np.load("a.npy")).max() < 1e-4
    command("-o", "d.npy", "--tile", 64, "--aov", "depth")
    command("-o", "d.exr", "--tile", 64, "--aov", "depth")
    np.testing.assert_array_equal(load_image("d.exr"), np.load("d.npy"))


def test_explain_says_how_many_tiles(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run("explain", "--size", "32768x32768", capsys=capsys)
    assert "32768x32768 in " in out and " tiles of " in out and "a halo of " in out
    _, out, _ = run("explain", "--size", "640x360", "--tile", 160, "--json", capsys=capsys)
    assert json.loads(out)["tiles"]["columns"] == 4
    _, out, _ = run("explain", "--json", capsys=capsys)
    assert json.loads(out)["tiles"] is None


@pytest.mark.gl
@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("--tile 0", "--tile 0: must be at least 64"),
        ("--tile -3", "--tile -3: must be at least 64"),
        ("--tile many", "--tile many: must be a whole number"),
        ("--tile 30000 --size 40000x40000", "use at most"),
        ("--tile 64 --turntable 3 -o turn", "--tile is for one picture"),
        ("--tile 64 -o a.exr --size 60000x60000", "EXR files are made in memory"),
    ],
)
def test_bad_tiles(
    arguments: str, expected: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert expected in refused(capsys, "render", *arguments.split())
    assert list(tmp_path.iterdir()) == []
