"""Pictures drawn in tiles: the same as drawn whole, and not lost by an interruption."""

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
from ssao_gl.camera import Camera
from ssao_gl.methods import registry
from ssao_gl.scene import Scene
from ssao_gl.tiled import Job, draw
from ssao_gl.tiles import Layout, layout, unguarded

from ..command_line import refused, run
from ..shapes import camera, plane, with_radius

SIZE = (640, 360)
SMALL = (160, 100)
STEP = 1 / 255 + 1e-6
ALL = ("image", "visibility", "depth", "normal", "color")
RIM = 4
"""Pixels along the border of a picture that a filter sees beyond."""
VIEWS = ("perspective", "off-centre", "orthographic", "plane", "plane off-centre", "plane orthographic")
FAST = [name for name in registry() if name != "reference"]
"""All methods but the exhaustive one, which would take minutes."""
CASES = [(view, name) for view in VIEWS for name in FAST if name != "lecture" or "orthographic" not in view]
"""The lecture's method refuses parallel projections."""


def off_centre(cam: Camera, size: tuple[int, int]) -> Camera:
    matrix = cam.lens.matrix(size).copy()
    matrix[0] += 0.4 * matrix[3]
    matrix[1] -= 0.25 * matrix[3]
    return Camera.from_matrix(matrix, cam.pose)


def views(embedded: Scene) -> dict[str, tuple[Scene, Camera]]:
    cam = embedded.cameras[0]
    tilted = plane(1.1)
    return {
        "perspective": (embedded, cam),
        "off-centre": (embedded, off_centre(cam, SIZE)),
        "orthographic": (embedded, Camera.orthographic(5.0, 0.0, 30.0, cam.pose)),
        "plane": (tilted, camera()),
        "plane off-centre": (tilted, off_centre(camera(), SIZE)),
        "plane orthographic": (tilted, Camera.orthographic(8.0, 0.1, 40.0)),
    }


def settings(name: str, blur: Any = None, **changes: Any) -> ao.Settings:
    method: Any = with_radius(ao.method(name), 0.25) if name != "lecture" else ao.Lecture(radius=0.05)
    return ao.Settings(method=method, blur=blur, **changes)


def stitched(
    renderer: ao.Renderer, scene: Scene, cam: Camera, made: ao.Settings, tile: int, aovs: tuple[str, ...]
) -> dict[str, np.ndarray]:
    """A picture of ``SIZE`` in tiles."""
    cut = layout(scene, cam, SIZE, made, aovs, tile=tile)
    assert cut is not None and cut.columns > 1 and cut.rows > 1 and cut.halo == cut.wanted
    return put_together(renderer, scene, cam, made, cut, aovs)


def put_together(
    renderer: ao.Renderer, scene: Scene, cam: Camera, made: ao.Settings, cut: Layout, aovs: tuple[str, ...]
) -> dict[str, np.ndarray]:
    """Tiles put together in memory."""
    rows: list[list[dict[str, np.ndarray]]] = []
    for index, piece in enumerate(cut.tiles()):
        if index % cut.columns == 0:
            rows.append([])
        picture = renderer.render(scene, piece.camera(cam, SIZE), piece.outer.size, unguarded(made), aovs=aovs, checked=True)
        rows[-1].append({name: piece.crop(array) for name, array in picture.arrays.items()})
    return {name: np.concatenate([np.concatenate([part[name] for part in row], 1) for row in rows]) for name in aovs}


@pytest.mark.parametrize("blur", [None, ao.Joint()], ids=["raw", "joint"])
@pytest.mark.parametrize(("view", "name"), CASES)
def test_tiles_are_the_whole(any_renderer: ao.Renderer, embedded: Scene, view: str, name: str, blur: Any) -> None:
    """2x2 tiles, the upper and the right ones smaller: planes to one step, at edges a few taps may move by a texel.

    Vertices are rounded to fractions of a pixel after the projection, which differs, so a tap that hits the border of
    two texels may take the other one. A seam along the tiles would be a hundred times as many pixels. At the rim of the
    picture the filter of a whole one does not see what is drawn around it, that of a tile does.
    """
    scene, cam = views(embedded)[view]
    made = settings(name, blur)
    whole = any_renderer.render(scene, cam, SIZE, made, aovs=("visibility",)).visibility
    off = np.abs(stitched(any_renderer, scene, cam, made, 336, ("visibility",))["visibility"] - whole)
    if getattr(made.method, "guard", 0):
        off = off[RIM:-RIM, RIM:-RIM]
    if scene is not embedded:
        assert off.max() <= STEP
    assert (off > STEP).mean() <= 1e-4 and (off > 0).mean() <= 1e-3


@pytest.mark.parametrize("blur", [ao.LectureBlur(), ao.Separable(radius=8)], ids=["lecture", "separable"])
@pytest.mark.parametrize("tile", [64, 80, 100, 160, 352])
def test_tiles_of_any_side_under_any_filter(any_renderer: ao.Renderer, embedded: Scene, tile: int, blur: Any) -> None:
    made, cam = settings("alchemy", blur), embedded.cameras[0]
    whole = any_renderer.render(embedded, cam, SIZE, made, aovs=("visibility",)).visibility
    off = np.abs(stitched(any_renderer, embedded, cam, made, tile, ("visibility",))["visibility"] - whole)
    assert (off > STEP).mean() <= 1e-4 and (off > 0).mean() <= 1e-3


def test_without_the_halo_there_are_seams(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """The halo is needed: what the tests above would find without it."""
    made, cam = settings("alchemy", ao.Joint()), embedded.cameras[0]
    whole = any_renderer.render(embedded, cam, SIZE, made, aovs=("visibility",)).visibility
    cut = layout(embedded, cam, SIZE, made, ("visibility",), tile=160)
    assert cut is not None
    bare = dataclasses.replace(cut, halo=0)
    off = np.abs(put_together(any_renderer, embedded, cam, made, bare, ("visibility",))["visibility"] - whole)
    assert (off > STEP).mean() > 5e-3


def test_each_tile_is_drawn_once_in_one_piece_of_memory(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """No more pixels are drawn than tiles with their halos have."""
    made, cam = settings("alchemy"), embedded.cameras[0]
    cut = layout(embedded, cam, SIZE, made, ("visibility",), tile=160)
    assert cut is not None
    drawn = sum(tile.outer.w * tile.outer.h for tile in cut.tiles())
    assert drawn <= cut.columns * cut.rows * (160 + 2 * cut.halo) ** 2
    assert max(cut.outer) <= 160 + 2 * cut.halo


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


def test_the_command_line_writes_the_same_files(command: Any) -> None:
    out = command("-o", "tiles", "--aov", ",".join(ALL), "--tile", 64, "--json", "tiles.json", "--radius", 0.3)
    assert out.startswith("tiles/ (10 files): ") and "160x100 in 3x2 tiles" in out
    command("-o", "whole", "--aov", ",".join(ALL), "--radius", 0.3)
    report = json.loads(Path("tiles.json").read_text())
    assert report["tiles"]["count"] == 6 and report["tiles"]["side"] == [64, 64] and report["size"] == [160, 100]
    for name in ALL:
        a, b = np.load(f"tiles/{name}.npy"), np.load(f"whole/{name}.npy")
        assert a.dtype == b.dtype and a.shape == b.shape
        with Image.open(f"tiles/{name}.png") as tiles, Image.open(f"whole/{name}.png") as whole:
            assert tiles.info == whole.info and tiles.mode == whole.mode
            assert (np.abs(np.asarray(tiles).astype(int) - np.asarray(whole)) > 1).mean() < 1e-3
    assert sorted(path.name for path in Path().iterdir()) == ["tiles", "tiles.json", "whole"]


def test_one_file_by_suffix_and_bits(command: Any) -> None:
    command("-o", "a.npy", "--tile", 64)
    command("-o", "a.png", "--tile", 64, "--aov", "visibility", "--bits", 16)
    with Image.open("a.png") as image:
        assert np.abs(np.asarray(image) / 65535 - np.load("a.npy")).max() < 1e-4
    command("-o", "d.npy", "--tile", 64, "--aov", "depth")
    command("-o", "d.exr", "--tile", 64, "--aov", "depth")
    np.testing.assert_array_equal(ao.images.load("d.exr"), np.load("d.npy"))  # type: ignore[attr-defined]


def test_explain_says_how_many_tiles(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run("explain", "--size", "32768x32768", capsys=capsys)
    assert "32768x32768 in " in out and " tiles of " in out and "a halo of " in out
    _, out, _ = run("explain", "--size", "640x360", "--tile", 160, "--json", capsys=capsys)
    assert json.loads(out)["tiles"]["columns"] == 4
    _, out, _ = run("explain", "--json", capsys=capsys)
    assert json.loads(out)["tiles"] is None


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("--tile 0", "--tile 0: must be at least 64"),
        ("--tile -3", "--tile -3: must be at least 64"),
        ("--tile many", "unable to convert"),
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


# Last, because a context of OSMesa takes those of EGL along when it is released

LIMITS = {"image": 1, "visibility": STEP, "depth": 1e-5, "normal": 1e-3, "color": 0}
"""What an array may be off by, depth relative to itself."""


def test_every_array_on_every_driver(renderer: ao.Renderer, embedded: Scene) -> None:
    """Depth is the same to the last bits, the rest but for pixels on the edges of triangles."""
    made, cam = settings("alchemy", ao.Joint()), embedded.cameras[0]
    whole = renderer.render(embedded, cam, SIZE, made, aovs=ALL).arrays
    drawn = stitched(renderer, embedded, cam, made, 160, ALL)
    for name, limit in LIMITS.items():
        a, b = (np.asarray(arrays[name], np.float64) for arrays in (drawn, whole))
        off = np.abs(a - b) / (np.maximum(whole["depth"], 1e-9) if name == "depth" else 1)
        assert (off > limit).mean() < 5e-4, name
