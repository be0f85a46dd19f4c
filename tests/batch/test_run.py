"""Whole batches in this process: what is drawn, skipped, redone, and told; every kind of place."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.batch.painter import Painter
from ssao_gl.batch.places import Folder
from ssao_gl.batch.results import Results
from ssao_gl.batch.rows import MARKS
from ssao_gl.io.images import load_image
from ssao_gl.loaders.camera_files import load_cameras

from .models import content, jobs, pyramid

pytestmark = pytest.mark.gl
AOVS = "image,visibility,depth,normal"


def draw(scenes: list[Path], output: Path, **more: object) -> Results:
    return ao.batch(scenes, output, **{"cameras": "orbit:2", "size": (32, 24), "aovs": AOVS, **more})  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("scenes")
    return [pyramid(folder / f"{name}.obj", height) for name, height in (("low", 0.5), ("high", 3.0))]


@pytest.fixture(scope="module")
def drawn(scenes: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("drawn") / "out"
    draw(scenes, output)
    return output


def test_pictures_are_those_of_a_renderer(drawn: Path, scenes: list[Path], any_renderer: ao.Renderer) -> None:
    scene = ao.load_scene(scenes[1])
    camera = load_cameras(drawn / "high/cameras.json")[1]
    picture = any_renderer.render(scene, camera, (32, 24), aovs=AOVS)
    for aov in ("visibility", "depth", "normal"):
        assert np.array_equal(np.load(drawn / f"high/orbit_0001/{aov}.npy"), picture.arrays[aov])
    assert np.array_equal(load_image(drawn / "high/orbit_0001/image.png"), picture.image)


def test_done_is_skipped_and_changed_is_redone(scenes: list[Path], tmp_path: Path) -> None:
    mine = [pyramid(tmp_path / "a.obj"), pyramid(tmp_path / "b.obj", 2)]
    first = draw(mine, tmp_path / "out")
    assert (first.drawn, first.before, first.failed) == (4, 0, [])
    again = draw(mine, tmp_path / "out")
    assert (again.drawn, again.before) == (0, 4) and [row["name"] for row in again.rows] == [row["name"] for row in first.rows]
    pyramid(mine[0], 1.5)
    assert draw(mine, tmp_path / "out").drawn == 2, "a scene that changed"
    (tmp_path / "out/b/orbit_0001/depth.npy").write_bytes(b"short")
    assert draw(mine, tmp_path / "out").drawn == 1, "an output that is not whole"
    assert draw(mine, tmp_path / "out", settings=ao.Settings(method="alchemy")).drawn == 4
    assert draw(mine[:1], tmp_path / "out", cameras="orbit:3").drawn == 3
    rows = [json.loads(line) for line in (tmp_path / "out/results.jsonl").read_text().splitlines()]
    names = [row["name"] for row in rows]
    assert len(set(names)) == len(names) == 5 and not list((tmp_path / "out").rglob(".*"))


def test_one_broken_scene_stops_nothing(scenes: list[Path], tmp_path: Path) -> None:
    broken = tmp_path / "broken.glb"
    broken.write_bytes(b"glTF junk")
    results = draw([scenes[0], broken, scenes[1], tmp_path / "gone.obj"], tmp_path / "out")
    assert [row["name"] for row in results.failed] == ["gone", "broken/orbit_0000", "broken/orbit_0001"]
    assert all("\n" not in row["error"] and row["error"] for row in results.failed)
    assert results.drawn == 6 and len(list((tmp_path / "out").rglob("depth.npy"))) == 4
    with (tmp_path / "out/results.csv").open() as file:
        table = {row["name"]: row for row in csv.DictReader(file)}
    assert table["broken/orbit_0001"]["error"] and float(table["high/orbit_0000"]["coverage"]) > 0
    pyramid(tmp_path / "broken.glb").rename(tmp_path / "x.obj")
    (tmp_path / "x.obj").rename(broken)
    assert len(draw([scenes[0], broken], tmp_path / "out").failed) == 2, "tried again"


def test_what_is_cut_goes_on_with_the_same_bytes(drawn: Path, scenes: list[Path], tmp_path: Path) -> None:
    """Marks of a process that was killed stand for what it drew; what it had begun is drawn again."""
    place, painter = Folder(tmp_path / "out"), Painter("auto")
    begun = jobs(*scenes)
    asked = {"aovs": "visibility,depth"}
    assert "error" not in painter.draw(begun[2], place)
    (tmp_path / "out/low/orbit_0000").mkdir(parents=True)
    (tmp_path / "out/low/orbit_0000/.depth.part.npy").write_bytes(b"half")
    painter.release()
    results = draw(scenes, tmp_path / "out", **asked)
    assert (results.drawn, results.before) == (3, 1)
    draw(scenes, tmp_path / "whole", **asked)
    assert content(tmp_path / "out") == content(tmp_path / "whole")


def test_a_job_that_another_has_done_is_not_drawn_again(scenes: list[Path], tmp_path: Path) -> None:
    painter, job = Painter("auto"), jobs(scenes[0])[0]
    first = painter.draw(job, Folder(tmp_path))
    assert painter.draw(job, Folder(tmp_path)) == json.loads(json.dumps(first)) and first["seconds"] > 0
    painter.release()


def test_cameras_are_told_as_others_read_them(drawn: Path) -> None:
    own = load_cameras(drawn / "low/cameras.json")
    for file in ("transforms.json", "scene_camera.json"):
        for one, other in zip(own, load_cameras(drawn / "low" / file, (32, 24)), strict=True):
            assert np.allclose(one.pose, other.pose, atol=1e-12)
            assert np.allclose(one.intrinsics((32, 24)), other.intrinsics((32, 24)))
    entry = json.loads((drawn / "low/cameras.json").read_text())["cameras"][0]
    point = np.array([0.3, 0.2, -0.4, 1])
    clip = np.array(entry["opengl_projection"]) @ np.linalg.inv(entry["pose"]) @ point
    pixel = np.array(entry["opencv_intrinsics"]) @ (np.array(entry["opencv_world_to_camera"]) @ point)[:3]
    assert np.allclose(pixel[:2] / pixel[2], [16 + 16 * clip[0] / clip[3], 12 - 12 * clip[1] / clip[3]])
    frame = json.loads((drawn / "low/transforms.json").read_text())["frames"][0]
    assert (drawn / "low" / frame["file_path"]).is_file() and (drawn / "low" / frame["depth_file_path"]).is_file()


@pytest.mark.parametrize("suffix", [".zarr", ".h5"])
def test_a_store_holds_what_a_folder_does(suffix: str, drawn: Path, scenes: list[Path], tmp_path: Path) -> None:
    output = tmp_path / f"all{suffix}"
    assert not draw(scenes[:1], output).failed
    results = draw(scenes, output)
    assert (results.drawn, results.before) == (2, 2) and draw(scenes, output).before == 4
    if suffix == ".zarr":
        import zarr

        root = zarr.open(output, mode="r")
    else:
        import h5py

        root = h5py.File(output, "r")
    for path in drawn.rglob("*/*/*.*"):
        array = np.load(path) if path.suffix == ".npy" else load_image(path)
        found = np.asarray(root[path.relative_to(drawn).with_suffix("").as_posix()])
        assert np.array_equal(found, array) and found.dtype == array.dtype
    if suffix == ".h5":
        root.close()
    assert not list(tmp_path.rglob("*part*")) and not list(tmp_path.rglob(MARKS))


def test_an_object_store_holds_what_a_folder_does(drawn: Path, scenes: list[Path]) -> None:
    import fsspec

    url = "memory://batch/out"
    assert draw(scenes, url).drawn == 4 and draw(scenes, url).before == 4  # type: ignore[arg-type]
    files = fsspec.filesystem("memory")
    found = {name.removeprefix("/batch/out/"): files.cat_file(name) for name in files.find("/batch/out")}
    assert {name: data for name, data in found.items() if not name.startswith("results")} == content(drawn)


@pytest.mark.parametrize(
    ("output", "more", "told"),
    [
        ("a.png", {}, "suffix '.png'"),
        ("a.zarr", {"formats": ("npy",)}, "formats"),
        ("memory://a", {"workers": 2}, "memory"),
        ("a", {"workers": 2, "dask": "local:1"}, "exclude"),
        ("a", {"workers": -1}, "workers"),
        ("a", {"aovs": "deph"}, "depth"),
        ("a", {"formats": ("jpg",)}, "format"),
        ("nothing://a", {}, "nothing"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_drawn(
    output: str, more: dict[str, object], told: str, scenes: list[Path], tmp_path: Path
) -> None:
    where = output if "://" in output else tmp_path / output
    with pytest.raises(ao.SsaoError, match=told):
        draw(scenes, where, **more)  # type: ignore[arg-type]
    assert not list(tmp_path.rglob("*.npy"))


def test_scenes_come_by_pattern(scenes: list[Path], tmp_path: Path) -> None:
    results = ao.batch(str(scenes[0].parent / "*.obj"), tmp_path / "o", size=(16, 12), aovs="depth")
    assert [row["name"] for row in results.rows] == ["high/view", "low/view"]
    with pytest.raises(ao.SettingsError, match="no such files"):
        ao.batch("nothing*.glb", tmp_path / "o")
    with pytest.raises(ao.SettingsError, match="nothing to draw"):
        ao.batch([], tmp_path / "o")
