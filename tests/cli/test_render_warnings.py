"""What a scene file loses on the way is said, reported, and an error on demand; animations and points have options."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ..command_line import refused, run
from ..loaders.gltf_parts import Parts

pytestmark = pytest.mark.gl


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    parts = Parts(extensionsUsed=["XX_hologram"])
    path = tmp_path / "a.glb"
    path.write_bytes(parts.show(parts.quad()))
    return path


LOST = "uses glTF extensions that are not read: XX_hologram"


def test_warnings_stand_in_the_report(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = scene.with_name("a.json")
    code, _, err = run("render", scene, "--size", "16x12", "-o", scene.with_name("a.png"), "--json", report, capsys=capsys)
    assert code == 0 and err.count(LOST) == 1
    assert json.loads(report.read_text())["warnings"] == [LOST]


def test_strict(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run("render", scene, "--strict", "-o", scene.with_name("a.png"), capsys=capsys)
    assert code == 2 and f"{LOST} (--strict)" in err and not scene.with_name("a.png").exists()


def test_options_of_the_file(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "has no animations" in refused(capsys, "explain", scene, "--animation", "walk", "--time", "1")
    assert "must be above 0 (scene units)" in refused(capsys, "explain", scene, "--point-size", "0")


def test_a_camera_without_a_choice(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Said once, reported, and an error on demand; not said where one is chosen."""
    entry = {"eye": [0, 0, 3], "target": [0, 0, 0], "yfov_deg": 40}
    cameras = scene.with_name("a.cam.json")
    cameras.write_text(json.dumps({"cameras": [{**entry, "name": f"view {i}"} for i in range(200)]}))
    told = "1 of 200 cameras: the first one, 'view 0', is taken; choose by FILE:NAME"
    plain, report = scene.with_name("b.glb"), scene.with_name("a.json")
    parts = Parts()
    plain.write_bytes(parts.show(parts.quad()))
    words = ("--size", "16x12", "-o", scene.with_name("a.png"))
    code, _, err = run("render", plain, "--camera", cameras, *words, "--json", report, capsys=capsys)
    assert code == 0 and err.count(told) == err.count("\n") == 1
    assert [told in line for line in json.loads(report.read_text())["warnings"]] == [True]
    assert "(--strict)" in refused(capsys, "render", plain, "--camera", cameras, "--strict", *words)
    assert run("render", plain, "--camera", f"{cameras}:view 7", "--strict", *words, capsys=capsys)[2] == ""
