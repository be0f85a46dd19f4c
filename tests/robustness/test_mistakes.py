"""What a newcomer gets wrong in the first hour: every answer is one line that names what was expected, or the cure.

The words after each mistake are asked for as they stand. Hostile input has a place of its own: test_bad_input.py.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

import ssao_gl as ao
from tests.command_line import refused, run

LINES: dict[str, str] = {
    # commands
    "rendr box.glb": "Did you mean 'render'?",
    "box.glb": "Did you mean 'ssao-gl render box.glb'?",
    "box.glb -o out.png": "Did you mean 'ssao-gl render box.glb -o out.png'?",
    "-o out.png": "options stand behind a command, as in: ssao-gl render model.glb -o a.png",
    "--vesion": "Did you mean '--version'?",
    "-v rendr box.glb": "Did you mean 'render'?",
    "version": "Did you mean '--version'?",
    "help rendr": "Did you mean 'render'?",
    "render -help": "Did you mean '--help'?",
    # files
    "render nofile.glb": "nofile.glb: no such file; expected a scene file",
    "render folder": "folder: is a folder; expected a scene file",
    "render photo.png": "unknown mesh format '.png'; can be read: bz2, glb, gltf,",
    "render box.glb out.png": "'out.png': too many words. The output is named by -o",
    "render box.glb --camera front": "expected a camera file, FILE.cam.json or FILE.cam.json:NAME",
    "render box.glb --camera box.cam.json:frnt": "no camera 'frnt'; it has front (or a number from 0 to 0). Did you mean 'front'?",
    "render box.glb --camera box.glb": "not JSON",
    "render box.glb --config settings.json": "settings.json: not TOML",
    "render box.glb --config none.toml": "no such file; expected a TOML file with settings",
    "compare photo.png": "EXPECTED is needed",
    "compare photo.png depth.npy": "cannot compare pictures of shape (48, 64, 3) and (48, 64)",
    # options
    "render box.glb --width 640": "Did you mean '--size WIDTHxHEIGHT'?",
    "render box.glb --fov 60": "Did you mean '--yfov-deg DEGREES (of the height)'?",
    "render box.glb --yfov 60": "Did you mean '--yfov-deg'?",
    "render box.glb --out a.png": "Did you mean '--output'?",
    "render box.glb --no-blur": "Did you mean '--blur none'?",
    "render box.glb --quality high": "Did you mean '--preset NAME'?",
    "render box.glb --gpu": "Did you mean '--gl NAME'?",
    "render box.glb --steps 3": "It is a setting: --set steps=VALUE.",
    "render box.glb --ambient 1": "It is a setting: --set shading.ambient=VALUE.",
    "render box.glb --tolerance 1": "It is a setting: --set blur.tolerance=VALUE.",
    "render box.glb --radius": "--radius needs a value: Reach, in scene units or as a share of the scene's size, like 10%",
    "apply photo.png": "--depth is needed: Depth, (h, w): NPY, NPZ, EXR",
    # values
    "render box.glb --method ssao": "there are bitmask, alchemy, aov, baked, crytek, field, gtao, hbao,",
    "render box.glb --method GTAO": "Did you mean 'gtao'?",
    "render box.glb --preset best": "bitmask has no preset 'best'; it has draft, low, medium, high, ultra.",
    "render box.glb --method lecture --preset ultra": "lecture has no preset 'ultra'; it has 4, 8, 16.",
    "render box.glb --blur gauss": "unknown blur 'gauss'; there are none, joint, separable, lecture.",
    "render box.glb --samples 16": "its taps are set by --set slices=2 --set steps=9 (what it has now), or by --preset",
    "render box.glb --method lecture --samples 4.7": "--samples 4.7: must be a whole number",
    "render box.glb --set radus=3": "Did you mean 'radius'?",
    "render box.glb --set slices 3": "'3': too many words. The output is named by -o, numbers of one option are joined by commas, settings are KEY=VALUE",
    "render box.glb --radius -1": "bitmask.radius=-1.0: must be above 0 (scene units)",
    "render box.glb --radius 10cm": "must be a number of scene units, or a share of the scene's size above 0, like 10%",
    "render box.glb --size 640": "--size 640: must be WIDTHxHEIGHT in whole pixels, like 1280x720",
    "render box.glb --size 640,480": "must be WIDTHxHEIGHT in whole pixels, like 1280x720",
    "render box.glb --size 640.5x480": "must be WIDTHxHEIGHT in whole pixels, like 1280x720",
    "render box.glb --eye 1,2": "--eye 1,2: must be three numbers, like 1,2.5,-3",
    "render box.glb --up w": "must be three numbers, like 1,2.5,-3, or an axis: x, y or z",
    "render box.glb --yfov-deg 200": "--yfov-deg 200: must lie between 0 and 180 degrees",
    "render box.glb --yfov-deg 60deg": "--yfov-deg 60deg: must be a number",
    "render box.glb --max-error 5%": "--max-error 5%: must be a number, like 0.05",
    "render box.glb --background red": "must look like #rrggbb or #rrggbbaa, or be one of white, black, transparent",
    "render box.glb --gl cuda": "there are auto, egl-es, egl-gl, osmesa, angle, swiftshader, native.",
    "render box.glb --time 1": "is the moment of an animation; add --animation NAME",
    "apply photo.png --depth depth.npy": "one of --yfov-deg, --intrinsics fx,fy,cx,cy, --ortho HEIGHT or --camera FILE",
    "apply photo.png --depth depth.npy --intrinsics 525,525": "must be fx,fy,cx,cy in pixels",
    "apply photo.png --depth depth.npy --yfov-deg 60 --strength 50%": "--strength 50%: must be a number, like 0.5",
    "bench box.glb --rounds 0": "--rounds 0: must be at least 1",
    # outputs
    "render box.glb -o a.jpg": "-o a.jpg: unknown suffix '.jpg'; use .png, .npy, .exr, or a folder.",
    "render box.glb -o none/a.png": "cannot write none/a.png: there is no folder none",
    "render box.glb --aov normals": "Did you mean 'normal'?",
    "render box.glb --aov depth,normal -o a.png": "one file holds one AOV; give a folder for depth, normal",
    "render box.glb --turntable 4 -o a.mp4": "use .png, .npy, .exr, .gif, .webp, .apng, or a folder.",
    "render box.glb --dump-config a.json": "unknown suffix '.json'; use .toml.",
}


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene, a camera, a photo and its depth, and with files that are none of these."""
    monkeypatch.chdir(tmp_path)
    trimesh.creation.box().export("box.glb")
    camera = {"name": "front", "eye": [3, 3, 3], "target": [0, 0, 0], "yfov_deg": 40}
    Path("box.cam.json").write_text(json.dumps({"cameras": [camera]}))
    Path("settings.json").write_text('{"method": "gtao"}')
    Path("folder").mkdir()
    Image.fromarray(np.full((48, 64, 3), 200, np.uint8)).save("photo.png")
    np.save("depth.npy", np.full((48, 64), 5, np.float32))
    return tmp_path


@pytest.mark.gl
@pytest.mark.parametrize("line", LINES)
def test_command_line(line: str, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(place.rglob("*"))
    if line.startswith("-v "):  # shows where, too
        code, _, err = run(*line.split(), capsys=capsys)
        assert code == 2 and LINES[line] in err.splitlines()[-1]
    else:
        assert LINES[line] in refused(capsys, *line.split())
    assert sorted(place.rglob("*")) == before, "nothing is left behind"


@pytest.mark.gl
def test_looking_the_wrong_way_is_said(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A picture of nothing is drawn, since it was asked for, with one line on standard error that names the cure."""
    away = ("--eye", "0,0,5", "--target", "0,0,9", "-o", "a.png", "--size", "16x12", "--json", "a.json")
    code, _, err = run("render", "box.glb", *away, capsys=capsys)
    assert (
        code == 0
        and err == "ssao-gl: nothing is seen: box.glb lies behind the camera; look at it by --target, or look_at(eye, target)\n"
    )
    assert json.loads(Path("a.json").read_text())["warnings"] == [err.removeprefix("ssao-gl: ").strip()]
    beside = ("--eye", "0,0,5", "--target", "9,0,-1", "--yfov-deg", 20, "-o", "a.png", "--size", "16x12")
    assert "nothing is seen" in run("render", "box.glb", *beside, capsys=capsys)[2]
    inside = ("--eye", "0,0,0", "--target", "0,0,9", "-o", "a.png", "--size", "16x12")
    assert run("render", "box.glb", *inside, capsys=capsys)[2] == ""


DEPTH = np.full((48, 64), 5, np.float32)
COLOR = np.full((48, 64, 3), 200, np.uint8)
BOX = trimesh.creation.box()
CAMERA = ao.Camera.perspective(1.0, 0.1, 100.0)
AWAY: Any = np.full((4, 4), np.nan)
ANY: Any = ao

CALLS: dict[str, tuple[Callable[[], object], type[Exception], str]] = {
    "missing file": (lambda: ao.render("none.glb"), ao.SceneError, "no such file; expected a scene file"),
    "nothing": (lambda: ao.render(None), ao.SceneError, "expected a path, Scene, Volume, trimesh.Trimesh, trimesh.Scene, pyrender.Scene, pyvista.Plotter"),
    "size as one number": (lambda: ANY.render(BOX, size=640), ao.SettingsError, "must be (width, height) in whole pixels"),
    "size as text": (lambda: ANY.render(BOX, size="640x480"), ao.SettingsError, "like (1280, 720)"),
    "size for camera": (lambda: ao.render(BOX, (640, 480)), ao.SettingsError, "the size is the argument after it: size=(width, height)"),
    "pose for camera": (lambda: ao.render(BOX, np.eye(4)), ao.SettingsError, "expected a Camera, by Camera.perspective or Camera.pinhole"),
    "unknown method": (lambda: ao.render(BOX, method="gtoa"), ao.SettingsError, "Did you mean 'gtao'?"),
    "class for method": (lambda: ANY.render(BOX, method=ao.Bitmask), ao.SettingsError, "make one of it: Bitmask()"),
    "dict for method": (lambda: ANY.render(BOX, method={"radius": 1}), ao.SettingsError, "settings like Bitmask(radius=0.3)"),
    "unknown blur": (lambda: ao.render(BOX, blur="gauss"), ao.SettingsError, "there are none, joint, separable, lecture."),
    "True for blur": (lambda: ANY.render(BOX, blur=True), ao.SettingsError, "must be a name in quotes, or settings like Joint(radius=2)"),
    "dict for shading": (lambda: ANY.Settings(shading={"ambient": 1}), ao.SettingsError, "must be a Shading, like Shading(ambient=0.75)"),
    "unknown AOV": (lambda: ao.render(BOX, aovs="normals"), ao.SettingsError, "Did you mean 'normal'?"),
    "unknown provider": (lambda: ao.render(BOX, provider="cuda"), ao.SettingsError, "there are auto, egl-es,"),
    "negative radius": (lambda: ao.Bitmask(radius=-1), ao.SettingsError, "bitmask.radius=-1: must be above 0 (scene units)"),
    "radius NaN": (lambda: ao.Bitmask(radius=float("nan")), ao.SettingsError, "must be a finite number"),
    "half a step": (lambda: ANY.Bitmask(steps=2.5), ao.SettingsError, "bitmask.steps=2.5: must be a finite whole number"),
    "percent": (lambda: ao.Shading(ambient=75), ao.SettingsError, "shading.ambient=75: must be 0 to 1"),
    "background": (lambda: ao.Shading(background="red"), ao.SettingsError, "or be one of white, black, transparent"),
    "degrees": (lambda: ao.Camera.perspective(60, 0.1, 100), ao.SettingsError, "60 degrees are math.radians(60)"),
    "near and far swapped": (lambda: ao.Camera.perspective(1, 100, 0.1), ao.SettingsError, "zfar=0.1 must lie behind znear=100"),
    "pose NaN": (lambda: ao.Camera.perspective(1, 0.1, 9, AWAY), ao.SettingsError, "pose must be a finite (4, 4) matrix"),
    "pose 3 x 3": (lambda: ao.Camera.perspective(1, 0.1, 9, np.eye(3)), ao.SettingsError, "(4, 4) matrix, got shape (3, 3)"),
    "pinhole size": (lambda: ANY.Camera.pinhole(525, 525, 320, 240, 640), ao.SettingsError, "must be (width, height) of the image in pixels"),
    "look at itself": (lambda: ao.look_at((1, 1, 1), (1, 1, 1)), ao.SettingsError, "eye and target are the same point"),
    "colour for depth": (lambda: ao.occlusion(COLOR, CAMERA), ao.FormatError, "depth is uint8 of shape (48, 64, 3); expected numbers of shape (h, w)"),
    "file for depth": (lambda: ANY.occlusion("depth.npy", CAMERA), ao.FormatError, "depth.npy: no such file; expected a picture or array"),
    "ragged depth": (lambda: ANY.occlusion([[1, 2], [3]], CAMERA), ao.FormatError, "depth: expected an array"),
    "depth and camera swapped": (lambda: ANY.occlusion(CAMERA, DEPTH), ao.FormatError, "depth is a Camera; expected an array"),
    "colour as floats": (lambda: ao.apply(COLOR / 255, DEPTH, CAMERA), ao.FormatError, "expected uint8 sRGB of shape (48, 64, 3)"),
    "other shapes": (lambda: ao.apply(COLOR[:24], DEPTH, CAMERA), ao.FormatError, "expected uint8 sRGB of shape (48, 64, 3)"),
    "strength": (lambda: ao.apply(COLOR, DEPTH, CAMERA, strength=2), ao.SettingsError, "must be 0 to 1"),
    "kind of depth": (lambda: ao.occlusion(DEPTH, CAMERA, depth_kind="planar"), ao.SettingsError, "must be 'eye' (distance along the view axis), 'window'"),
    "vertices NaN": (lambda: ao.Scene.from_arrays(np.full((3, 3), np.nan), [[0, 1, 2]]), ao.SceneError, "3 vertices are not finite numbers"),
    "quads": (lambda: ao.Scene.from_arrays(np.zeros((4, 3)), [[0, 1, 2, 3]]), ao.SceneError, "triangles (m, 3), got (4, 3) and (1, 4)"),
    "index out of range": (lambda: ao.Scene.from_arrays(np.zeros((3, 3)), [[0, 1, 3]]), ao.SceneError, "names vertex 3, but there are only 3"),
    "mesh for a renderer": (lambda: ANY.Renderer().render(BOX), ao.SceneError, "expected a Scene: ssao_gl.as_scene(...) makes one"),
    "method for settings": (lambda: ANY.Renderer().render(ao.as_scene(BOX), settings=ao.Bitmask()), ao.SettingsError, "Settings(method=Bitmask())"),
    "effect without a context": (
        lambda: ANY.Effect(None, (64, 48), ao.Settings(method=ao.Bitmask(radius=1))), ao.ContextError, "expected a moderngl.Context"
    ),
    "effect without a radius": (lambda: ANY.Effect(None, (64, 48)), ao.SettingsError, "give bitmask a radius, in the units of your depth"),
    "suffix": (lambda: ao.Picture({"image": COLOR}).save("a.jpg"), ao.FormatError, "use .png, .npy, .exr, or a folder"),
    "AOV that is not there": (lambda: ao.Picture({"image": COLOR}).depth, AttributeError, "ask for it: aovs=('image', 'depth')"),
    "misspelt AOV": (lambda: ao.Picture({"image": COLOR}).imgae, AttributeError, "Did you mean 'image'?"),
    "misspelt function": (lambda: ANY.rendr, AttributeError, "Did you mean 'render'?"),
    "method by its class": (lambda: ANY.GTAO, AttributeError, "Methods go by name: ssao_gl.method('gtao')."),
}  # fmt: skip


@pytest.mark.gl
@pytest.mark.parametrize("name", CALLS)
def test_python(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    call, kind, words = CALLS[name]
    with pytest.raises(kind) as caught:
        call()
    assert words in str(caught.value) and "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.gl
def test_names_are_taken_for_settings() -> None:
    """What can mean one thing only is no mistake."""
    assert ANY.Settings(method="gtao").method == ao.method("gtao") and ANY.Settings(blur="none").blur is None
    assert ANY.Settings(blur="lecture").blur == ao.LectureBlur()


@pytest.mark.gl
def test_a_camera_that_looks_away_is_said(caplog: pytest.LogCaptureFixture) -> None:
    away = ao.Camera.perspective(1, 0.01, 10, ao.look_at((0, 0, 5), (0, 0, 9)))
    assert (ao.render(BOX, away, (16, 12)).visibility == 1).all()
    assert "lies behind the camera" in caplog.text and "look_at(eye, target)" in caplog.text


def test_there_are_enough() -> None:
    assert len(LINES) >= 40 and len(CALLS) >= 20 and all(LINES.values()) and all(words for _, _, words in CALLS.values())
