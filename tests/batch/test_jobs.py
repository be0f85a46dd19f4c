"""Jobs: what changes their identity, and how their files are called."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import ssao_gl as ao
from ssao_gl.batch.inputs import content_digest, files_of
from ssao_gl.batch.jobs import jobs_of
from ssao_gl.batch.request import Request
from ssao_gl.batch.views import Around

from .models import jobs, pyramid


def identities(*scenes: Path, **more: object) -> set[str]:
    return {job.identity for job in jobs(*scenes, **more)}


def test_an_identity_holds_for_equal_input_only(tmp_path: Path) -> None:
    scene = pyramid(tmp_path / "a.obj")
    first = identities(scene)
    assert identities(scene) == first and len(first) == 2
    for more in (
        {"settings": ao.Settings(method="alchemy")},
        {"share": 0.1},
        {"around": Around(seed=2)},
        {"provider": "osmesa"},
    ):
        assert not identities(scene, **more) & first, more
    assert not identities(scene, cameras="orbit:3") & first, "the second of three stands elsewhere"
    pyramid(scene, height=2)
    assert not identities(scene) & first


def test_files_that_a_scene_names_count(tmp_path: Path) -> None:
    scene = pyramid(tmp_path / "a.obj")
    scene.write_text("mtllib a.mtl\n" + scene.read_text())
    (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd My Wood.png\n")
    (tmp_path / "my wood.png").write_bytes(b"1")
    (tmp_path / "other.png").write_bytes(b"1")
    assert [path.name for path in files_of(scene)] == ["a.obj", "a.mtl", "my wood.png"]
    before = content_digest(scene)
    (tmp_path / "other.png").write_bytes(b"2")
    assert content_digest(scene) == before
    (tmp_path / "my wood.png").write_bytes(b"2")
    assert content_digest(scene) != before


def test_names_tell_scenes_and_cameras_apart(tmp_path: Path) -> None:
    for folder in ("x", "y"):
        (tmp_path / folder).mkdir()
    same = [pyramid(tmp_path / "x" / "a.obj"), pyramid(tmp_path / "y" / "a.obj"), pyramid(tmp_path / "b b.obj")]
    assert [job.name for job in jobs(*same)][::2] == ["x/a.obj/orbit_0000", "y/a.obj/orbit_0000", "b_b/orbit_0000"]
    twice = jobs(same[2], same[2])
    assert [job.name for job in twice] == [f"b_b/orbit_{index:04d}{more}" for more in ("", "-2") for index in (0, 1)]
    named = jobs(same[2], names="{aov}/{number:06d}")
    assert named[1].files == {"visibility": ["visibility/000001.npy"], "depth": ["depth/000001.npy"]}


@pytest.mark.parametrize(
    "names", ["{scene}", "{scene}/{camera}/{what}", "{", "../{scene}{camera}{aov}", "{camera}/{aov}", "{scene}/{camera}"]
)
def test_names_that_cannot_be_are_refused(names: str, tmp_path: Path) -> None:
    with pytest.raises(ao.SettingsError, match="names"):
        jobs(pyramid(tmp_path / "a.obj"), names=names)


def test_a_scene_that_cannot_be_read_costs_its_own_views_only(tmp_path: Path) -> None:
    good, bad = pyramid(tmp_path / "a.obj"), tmp_path / "gone.obj"
    found, broken = jobs_of([(bad, Request(cameras="orbit:3")), (good, Request(cameras="orbit:2"))])
    assert len(found) == 2 and [one.name for one in broken] == ["gone"] and "no such file" in broken[0].error


def test_a_view_of_a_file_is_as_its_camera(tmp_path: Path) -> None:
    scene, file = pyramid(tmp_path / "a.obj"), tmp_path / "c.json"
    entry = {"name": "f", "eye": [0, 1, 5], "target": [0, 0, 0], "yfov_deg": 40}
    file.write_text(json.dumps({"cameras": [entry]}))
    first = identities(scene, cameras=f"{file}:all")
    file.write_text(json.dumps({"cameras": [{**entry, "yfov_deg": 41}]}))
    assert identities(scene, cameras=f"{file}:all") != first
