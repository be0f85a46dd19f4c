"""Lamps of glTF files and of pyrender's scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.loaders.load import load_scene
from ssao_gl.loaders.pyrender_scenes import from_pyrender

from .gltf_parts import Parts


def lit_file(path: Path, lights: list[dict[str, Any]], **node: Any) -> Path:
    parts = Parts()
    parts.tree["meshes"] = [{"primitives": [parts.quad()]}]
    hung = [{"extensions": {"KHR_lights_punctual": {"light": i}}, **node} for i in range(len(lights))]
    parts.tree["nodes"] = [{"mesh": 0}, *hung]
    parts.tree["extensionsUsed"] = ["KHR_lights_punctual"]
    parts.tree["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    path.write_bytes(parts.show())
    return path


def test_lights_of_a_gltf_file(tmp_path: Path) -> None:
    lights = [
        {"type": "directional", "intensity": 3.0, "color": [1.0, 0.5, 0.0]},
        {"type": "spot", "range": 7.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.4}},
    ]
    half = np.sqrt(0.5)
    scene = load_scene(
        lit_file(tmp_path / "a.glb", lights, translation=[1, 2, 3], rotation=[-float(half), 0, 0, float(half)], scale=[2, 2, 2])
    )
    sun, spot = scene.lamps
    assert sun.kind == "directional" and sun.color == (3.0, 1.5, 0.0)
    np.testing.assert_allclose(sun.direction, (0, -1, 0), atol=1e-12)
    assert spot.place == (1.0, 2.0, 3.0) and spot.range == 7.0 and spot.cone == (0.1, 0.4)
    assert not scene.warnings


@pytest.mark.parametrize(
    "light", [{"type": "torch"}, {}, {"type": "point", "color": [1, 2]}, {"type": "point", "intensity": -1.0}, {"type": "point", "range": 0}]
)  # fmt: skip
def test_a_broken_light_is_noted_and_left_out(tmp_path: Path, light: dict[str, Any]) -> None:
    scene = load_scene(lit_file(tmp_path / "a.glb", [light, {"type": "point"}]))
    assert [lamp.kind for lamp in scene.lamps] == ["point"] and "light of the file is unusable" in scene.warnings[0]


def test_lights_of_pyrender() -> None:
    import pyrender
    import trimesh

    scene = pyrender.Scene()
    scene.add(pyrender.Mesh.from_trimesh(trimesh.creation.box()))
    pose = np.eye(4)
    pose[:3, 3] = 1, 2, 3
    scene.add(pyrender.SpotLight(color=[1.0, 0.5, 0.25], intensity=4.0, innerConeAngle=0.2, outerConeAngle=0.3), pose=pose)
    scene.add(pyrender.DirectionalLight(intensity=2.0))
    sun, spot = from_pyrender(scene).lamps
    assert sun.kind == "directional" and sun.color == (2.0, 2.0, 2.0) and sun.direction == (0.0, 0.0, -1.0)
    assert spot.color == (4.0, 2.0, 1.0) and spot.place == (1.0, 2.0, 3.0) and spot.cone == (0.2, 0.3)


def test_a_lamp_that_cannot_be() -> None:
    from ssao_gl.scene.lamps import Lamp

    with pytest.raises(ao.SceneError, match="has no direction"):
        Lamp("directional", direction=(0.0, 0.0, 0.0))
