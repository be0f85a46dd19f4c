"""The command line, as people use it. What it does with bad input is in tests/robustness/test_bad_input.py."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from ssao_gl.cli import main
from ssao_gl.cli.help_pages import COMMANDS
from ssao_gl.cli.options import ViewOptions
from ssao_gl.io import images
from ssao_gl.methods.registry import general, registry
from ssao_gl.scene.lens import Orthographic, Perspective
from ssao_gl.scene.sample_scene import default_scene

SIZE = ("--size", "64x48")


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run a command in an empty folder; gives what it printed and fails when it does."""
    monkeypatch.chdir(tmp_path)

    def command(*arguments: object, code: int = 0) -> str:
        with pytest.raises(SystemExit) as ended:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert (ended.value.code or 0) == code, err
        return out

    return command


def names(folder: str | Path = ".") -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in Path(folder).rglob("*") if path.is_file())


# render


@pytest.mark.gl
def test_without_arguments(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A picture of the embedded scene, and one line that says so."""
    out = run()
    assert names() == ["ssao.png"] and out.count("\n") == 1
    assert out.startswith("ssao.png: embedded scene, ") and "1280x720" in out and " ms" in out
    with Image.open("ssao.png") as image:
        assert image.size == (1280, 720) and image.mode == "RGB"
        shown = json.loads(image.info["ssao_gl:settings"])
    assert shown["method"] == "bitmask" and shown["bitmask"]["radius"] > 0


@pytest.mark.gl
def test_one_file_by_suffix(run: Any) -> None:
    run("render", "-o", "a.npy", *SIZE)
    visibility = np.load("a.npy")
    assert visibility.shape == (48, 64) and visibility.dtype == np.float32
    run("render", "-o", "a.png", "--aov", "visibility", "--bits", 16, *SIZE)
    assert np.abs(images.load_image("a.png") / 65535 - visibility).max() < 1e-4
    run("render", "-o", "a.exr", "--aov", "depth", *SIZE)
    run("render", "-o", "d.npy", "--aov", "depth", *SIZE)
    assert np.array_equal(images.load_image("a.exr"), np.load("d.npy"))


@pytest.mark.gl
def test_folder_gets_every_aov(run: Any) -> None:
    out = run("render", "-o", "out/", "--aov", "visibility,depth,normal,color,image", *SIZE)
    aovs = ["color", "depth", "image", "normal", "visibility"]
    assert names("out") == [f"{aov}.{suffix}" for aov in aovs for suffix in ("npy", "png")]
    assert out.startswith("out/ (10 files): ")
    run("render", "-o", "out", *SIZE)
    assert len(names("out")) == 10, "the same names again"


@pytest.mark.gl
def test_json(run: Any) -> None:
    run("render", "-o", "a.png", "--json", "a.json", *SIZE)
    report = json.loads(Path("a.json").read_text())
    assert {p["name"] for p in report["passes"]} >= {"gbuffer", "bitmask"} and report["ao_ms"] > 0
    assert report["size"] == [64, 48] and report["provider"] and report["renderer"]
    printed = run("render", "-o", "a.png", "--json", "-", *SIZE)
    assert json.loads(printed)["size"] == [64, 48], "nothing else on standard output"


@pytest.mark.gl
def test_quiet(run: Any) -> None:
    assert run("render", "-q", "-o", "a.png", *SIZE) == "" and names() == ["a.png"]


@pytest.mark.gl
def test_settings_from_everywhere(run: Any) -> None:
    Path("a.toml").write_text('method = "lecture"\n[lecture]\nsamples = 8\n')
    run("render", "--config", "a.toml", "--radius", "0.02", "--blur", "none", "-o", "a.png", "--json", "a.json", *SIZE)
    settings = json.loads(Path("a.json").read_text())["settings"]
    assert settings["method"] == "lecture" and settings["blur"] == "none"
    assert settings["lecture"]["samples"] == 8 and settings["lecture"]["radius"] == 0.02


@pytest.mark.gl
@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--method", "gtao", "--blur", "none", "--set", "shading.ambient=0.5", "--keep", "open"),
        ("--preset", "high", "--radius", "7%", "--set", "blur.radius=3", "--set", "normals=shading"),
    ],
)
def test_settings_are_dumped_and_read(options: tuple[str, ...], run: Any) -> None:
    """What --dump-config writes gives the same file by --config."""
    run("render", *options, "--dump-config", "a.toml", "-o", "a.png", *SIZE)
    run("render", "--config", "a.toml", "-o", "b.png", *SIZE)
    assert Path("a.png").read_bytes() == Path("b.png").read_bytes()
    assert ("\nradius = " in Path("a.toml").read_text().split("[blur")[0]) == ("--radius" in options), (
        "what is automatic stays so"
    )


@pytest.mark.gl
def test_radius_as_a_share(run: Any) -> None:
    """Of the scene's diagonal; of the image for methods whose radius is one."""
    trimesh.creation.box((3, 4, 12)).export("box.ply")
    for options, radius in ((("--radius", "10%"), 1.3), (("--method", "lecture", "--radius", "10%"), 0.1)):
        run("render", "box.ply", *options, "-o", "a.png", "--json", "a.json", *SIZE)
        settings = json.loads(Path("a.json").read_text())["settings"]
        assert settings[settings["method"]]["radius"] == pytest.approx(radius)
    assert "radius 1.3," in run("truth", "box.ply", "--radius", "10%", "--spp", 1, "--no-cache", "-o", "t.png", *SIZE)
    prepare()
    run("apply", "--depth", "d.npy", "--ortho", 3, "--radius", "10%", "-o", "a.png", "--json", "a.json")
    radius = json.loads(Path("a.json").read_text())["settings"]["bitmask"]["radius"]
    run("apply", "--depth", "d.npy", "--ortho", 3, "-o", "a.png", "--json", "a.json")
    assert json.loads(Path("a.json").read_text())["settings"]["bitmask"]["radius"] == pytest.approx(0.3 * radius)


@pytest.mark.gl
@pytest.mark.parametrize("more", [(), ("--tile", 64)])
def test_transparent_background(more: tuple[Any, ...], run: Any) -> None:
    """RGBA in PNG and in arrays, at once and in tiles."""
    trimesh.creation.icosphere(3).export("ball.ply")
    wide = ("--size", "160x120", "--background", "transparent")
    run("render", "ball.ply", "-o", "out/", "--aov", "image,depth", *wide, *more)
    image, depth = np.load("out/image.npy"), np.load("out/depth.npy")
    assert image.shape == (120, 160, 4) and np.array_equal(image[..., 3] == 255, depth > 0) and (image[depth == 0] == 0).all()
    assert np.array_equal(images.load_image("out/image.png"), image)


@pytest.mark.gl
@pytest.mark.parametrize("suffix", ["gif", "webp", "apng"])
def test_transparent_turntable(suffix: str, run: Any) -> None:
    trimesh.creation.icosphere(3).export("ball.ply")
    run("render", "ball.ply", "--turntable", 2, "-o", f"turn.{suffix}", "--background", "transparent", *SIZE)
    with Image.open(f"turn.{suffix}") as image:
        alpha = np.asarray(image.convert("RGBA"))[..., 3]
    assert alpha[0, 0] == 0 and alpha[24, 32] == 255


@pytest.mark.gl
def test_old_background(run: Any) -> None:
    run("render", "--background", "white", "-o", "a.png", *SIZE)
    run("render", "-o", "b.png", *SIZE)
    white, calm = images.load_image("a.png"), images.load_image("b.png")
    changed = (white != calm).any(-1)
    assert (white[changed] == 255).all() and (calm[changed] == [0x9A, 0xA5, 0xB1]).all() and changed.any()


def test_up_by_an_axis(tmp_path: Path) -> None:
    """``--up z`` stands the file on its z axis, whichever camera looks at it."""
    trimesh.creation.cylinder(0.5, 3).export(tmp_path / "part.obj")
    trimesh.creation.cylinder(0.5, 3).export(tmp_path / "part.stl")

    def pose(name: str, **options: Any) -> Any:
        view = ViewOptions(size="64x48", **options)
        return view.choose(view.load(tmp_path / name)).pose

    assert pose("part.obj", up="z") == pytest.approx(pose("part.stl"), abs=1e-6) == pose("part.obj", up_axis="z")
    assert pose("part.stl", up="y") == pytest.approx(pose("part.obj"), abs=1e-6)
    assert pose("part.obj", up="z", eye="5,4,3") == pytest.approx(pose("part.obj", up="0,0,1", eye="5,4,3"))
    assert pose("part.obj", up="z")[2, 1] > 0.8 and pose("part.obj", up="x")[0, 1] > 0.8


@pytest.mark.gl
def test_spellings_of_numbers(run: Any) -> None:
    """Vectors and sizes by spaces or commas, and whole floats."""
    run("render", "--eye", "5,4,3", "--target", "0,0,0", "-o", "a.png", *SIZE)
    run("render", "--eye", 5, 4, 3, "--target", 0, 0, 0, "-o", "b.png", "--size", "64.0x48.0")
    run("render", "--eye", 5, 4, 3, "--target", 0, 0, 0, "-o", "c.png", "--size", 64, 48)
    assert Path("a.png").read_bytes() == Path("b.png").read_bytes() == Path("c.png").read_bytes()


@pytest.mark.gl
@pytest.mark.parametrize("method", sorted(general()))
def test_every_method(method: str, run: Any) -> None:
    run("render", "--method", method, "-o", "a.npy", *SIZE)
    assert 0 <= np.load("a.npy").min() < np.load("a.npy").max() <= 1


@pytest.mark.gl
def test_scene_files(run: Any) -> None:
    trimesh.creation.icosphere(3).export("ball.ply")
    assert "ball.ply, 1,280 triangles" in run("render", "ball.ply", "-o", "a.npy", "--aov", "depth", *SIZE)
    depth = np.load("a.npy")
    assert (depth[20:28, 28:36] > 0).all() and (depth[0] == 0).all(), "in the middle, with a margin"


@pytest.mark.gl
def test_camera_of_a_file(run: Any) -> None:
    camera = {"name": "top", "eye": [0, 9, 0], "target": [0, 0, 0], "up": [0, 0, -1], "yfov_deg": 60, "ao_radius": 0.125}
    Path("a.cam.json").write_text(json.dumps({"cameras": [camera]}))
    run("render", "--camera", "a.cam.json:top", "-o", "a.png", "--json", "a.json", *SIZE)
    report = json.loads(Path("a.json").read_text())
    assert report["camera"] == "top" and report["settings"]["bitmask"]["radius"] == 0.125


@pytest.mark.gl
def test_negative_coordinates(run: Any) -> None:
    """Vectors may begin with a minus."""
    trimesh.creation.box().export("box.ply")
    aimed = ("--eye", "-5,0,0", "--target", "-0.5,0,0", "--up", "-0,0,1", "--yfov-deg", "30")
    run("render", "box.ply", *aimed, "-o", "a.npy", "--aov", "depth", *SIZE)
    assert np.load("a.npy")[24, 32] == pytest.approx(4.5, rel=1e-5)


@pytest.mark.gl
def test_turntable_of_files(run: Any) -> None:
    out = run("render", "--turntable", 3, "-o", "turn", *SIZE)
    assert names("turn") == ["0000.png", "0001.png", "0002.png"] and out == "turn/: 3 frames\n"
    assert not np.array_equal(images.load_image("turn/0000.png"), images.load_image("turn/0001.png"))
    run("render", "--turntable", 2, "-o", "both", "--aov", "image,depth", *SIZE)
    assert "0001/depth.npy" in names("both") and "0000/image.png" in names("both")


@pytest.mark.gl
@pytest.mark.parametrize("suffix", ["gif", "webp", "apng"])
def test_turntable_of_one_file(suffix: str, run: Any) -> None:
    run("render", "--turntable", 3, "-o", f"turn.{suffix}", *SIZE)
    with Image.open(f"turn.{suffix}") as image:
        assert image.size == (64, 48) and getattr(image, "n_frames", 1) == 3


# Views


def test_options_change_only_what_they_name() -> None:
    scene = default_scene()
    plain = ViewOptions(size="64x48").choose(scene)
    assert ViewOptions(size="64x48", znear=0.5).choose(scene).lens.matrix((64, 48))[0, 0] == plain.lens.matrix((64, 48))[0, 0]
    far = ViewOptions(size="64x48", zfar=math.inf).choose(scene).lens
    assert isinstance(far, Perspective) and far.zfar is None
    wide = ViewOptions(size="64x48", yfov_deg=90).choose(scene).lens
    assert isinstance(wide, Perspective) and wide.yfov == pytest.approx(math.pi / 2)
    flat = ViewOptions(size="64x48", ortho=7).choose(scene)
    assert isinstance(flat.lens, Orthographic) and flat.lens.height == 7
    np.testing.assert_array_equal(flat.pose, plain.pose)


def test_parallel_camera_stays_parallel(tmp_path: Path) -> None:
    camera = {"eye": [0, 9, 0], "target": [0, 0, 0], "up": [0, 0, -1], "ortho_height": 4, "znear": 1, "zfar": 20}
    path = tmp_path / "a.cam.json"
    path.write_text(json.dumps({"cameras": [camera]}))
    lens = ViewOptions(size="64x48", camera=str(path), zfar=12).choose(default_scene()).lens
    assert isinstance(lens, Orthographic) and (lens.height, lens.zfar) == (4, 12)
    lens = ViewOptions(size="64x48", camera=str(path), yfov_deg=40).choose(default_scene()).lens
    assert isinstance(lens, Perspective)


# apply


def prepare() -> None:
    depth = np.full((48, 64), 5, np.float32)
    depth[:, 32:] = 4.8
    depth[:5] = 0
    np.save("d.npy", depth)
    Image.fromarray(np.full((48, 64, 3), 200, np.uint8)).save("c.png")


@pytest.mark.gl
def test_apply(run: Any) -> None:
    prepare()
    out = run("apply", "c.png", "--depth", "d.npy", "--yfov-deg", 40, "--radius", 0.5, "-o", "a.png")
    assert out.startswith("a.png: 64x48, bitmask, ")
    shaded = images.load_image("a.png")
    assert (shaded[:4] == 200).all() and shaded.min() < 195
    run("apply", "c.png", "--depth", "d.npy", "--yfov-deg", 40, "--strength", 0, "-o", "b.png")
    assert (np.abs(images.load_image("b.png").astype(int) - 200) <= 1).all()
    run("apply", "--depth", "d.npy", "--ortho", 3, "-o", "v.npy")
    assert (np.load("v.npy")[:4] == 1).all()


@pytest.mark.gl
def test_apply_to_window_depth(run: Any) -> None:
    """Needs a radius in scene units, and takes it."""
    prepare()
    depth = np.load("d.npy")
    near, far = 0.5, 50.0
    with np.errstate(divide="ignore"):
        window = np.where(depth > 0, (far / (far - near)) * (1 - near / depth), 1).astype(np.float32)
    np.save("w.npy", window)
    lens = ("--intrinsics", "60,60,32,24", "--znear", near, "--zfar", far, "--radius", 0.5)
    run("apply", "--depth", "w.npy", "--depth-kind", "window", *lens, "-o", "w_out.npy")
    run("apply", "--depth", "d.npy", *lens, "-o", "d_out.npy")
    assert np.abs(np.load("w_out.npy") - np.load("d_out.npy")).max() <= 2 / 255


@pytest.mark.gl
def test_apply_into_a_folder(run: Any) -> None:
    prepare()
    run("apply", "c.png", "--depth", "d.npy", "--yfov-deg", 40, "-o", "out/", "--json", "a.json")
    assert {"image.png", "visibility.npy", "depth.npy", "normal.png"} <= set(names("out"))
    assert json.loads(Path("a.json").read_text())["settings"]["method"] == "bitmask"


# compare


def test_compare(run: Any) -> None:
    base = np.full((8, 8, 3), 100, np.uint8)
    other = base.copy()
    other[2, 3, 1] = 103
    images.save_image("a.png", base)
    images.save_image("b.png", other)
    assert run("compare", "a.png", "a.png", "--max-abs", 0).startswith("max 0, ")
    assert "max 3" in run("compare", "a.png", "b.png", "--max-abs", 3)
    out = run("compare", "a.png", "b.png", "--max-abs", 2, "--metric", "rmse,psnr", "--diff", "d.png", code=1)
    assert "over the limit of 2" in out and "rmse" in out and "psnr" in out
    assert images.load_image("d.png").shape == (8, 24, 3)


# Explanations


def test_explain(run: Any) -> None:
    out = run("explain", *SIZE)
    assert "gbuffer" in out and "bitmask" in out and "MiB" in out
    plan = json.loads(run("explain", "--json", "--aov", "visibility", *SIZE))
    assert plan["passes"][0]["name"] == "gbuffer" and "composite" not in str(plan["passes"])


def test_methods(run: Any) -> None:
    out = run("methods")
    for name in registry():
        assert f"{name}: " in out
    assert "scene units" in out and "blur joint: " in out
    assert "blur joint: " in run("methods", "joint") and "alchemy: " in run("methods", "alchemy")


@pytest.mark.parametrize("dialect", ["es300", "gl330"])
def test_shader(dialect: str, run: Any) -> None:
    listed = run("shader").split()
    assert "alchemy" in listed and "gbuffer.frag" in listed
    text = run("shader", "alchemy", "--dialect", dialect, "--define", "SAMPLES=7")
    assert text.startswith("#version ") and "#define SAMPLES 7" in text


@pytest.mark.gl
def test_doctor(run: Any) -> None:
    out = run("doctor")
    for name in ("egl-es", "egl-gl", "osmesa", "angle", "swiftshader", "native"):
        assert name in out


def test_version(run: Any) -> None:
    assert re.match(r"\d+\.\d+", run("--version"))


@pytest.mark.parametrize("command", [*COMMANDS, None])
def test_help(command: str | None, run: Any) -> None:
    """Each option says what it is; numbers of a kind say their unit, and what may be left out says what happens then."""
    out = run(*([command] if command else []), "-h")
    assert out.startswith("Usage: ssao-gl")
    if command in ("render", "apply", "explain"):
        for unit in ("scene units", "degrees", "pixels"):
            assert unit in out, unit
        assert "[default: " in out and "alchemy" in out
