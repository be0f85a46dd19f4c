"""Scenes from whatever a caller has: which way is up."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

import ssao_gl as ao

Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@pytest.mark.parametrize(("suffix", "up"), [("stl", Z), ("ply", Z), ("off", Z), ("obj", Y), ("glb", Y)])
def test_meshes_in_memory_agree_with_their_files(suffix: str, up: tuple[float, ...], tmp_path: Path) -> None:
    """What trimesh loaded stands as the file does, and so do automatic views."""
    path = tmp_path / f"part.{suffix}"
    trimesh.creation.cylinder(0.5, 3).export(path)
    file, memory = ao.as_scene(path), ao.as_scene(trimesh.load(path))
    assert file.up == memory.up == up
    assert file.default_camera().pose == pytest.approx(memory.default_camera().pose, abs=1e-6)


def test_up_can_be_said(tmp_path: Path) -> None:
    mesh = trimesh.creation.cylinder(0.5, 3)
    assert ao.as_scene(mesh).up == Y and ao.as_scene(mesh, up="z").up == Z
    mesh.export(tmp_path / "part.stl")
    for scene in (ao.as_scene(tmp_path / "part.stl", up="y"), ao.as_scene(ao.as_scene(mesh, up="z"), up="y")):
        assert scene.up == Y
    with pytest.raises(ao.SceneError, match="must be x, y, z or auto"):
        ao.as_scene(mesh, up="w")
