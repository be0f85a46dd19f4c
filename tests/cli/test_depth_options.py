"""Depth as people hold it, through the command line and through Python: the right answer, or one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.io.images import load_image
from ssao_gl.stress.analytic_depth import ball_depth, cast, flat

from ..command_line import refused, run

pytestmark = pytest.mark.gl

SIZE = (160, 120)
CAMERA = ao.Camera.pinhole(130, 130, 80, 60, SIZE)
Z = cast(CAMERA, SIZE, flat((0, -0.5, 0), (0, 1, 0), within=2.9), ball_depth((0, -0.2, -2), 0.3)).astype(np.float32)
SEEN = Z > 0
LENS = ("--intrinsics", "130,130,80,60")
RADIUS = ("--radius", "0.3")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    np.save("m.npy", Z)
    Image.fromarray(np.full((120, 160, 3), 128, np.uint8)).save("c.png")
    return tmp_path


@pytest.fixture
def apply(capsys: pytest.CaptureFixture[str]) -> Any:
    """Run the command; return visibility, and what it said on standard error."""

    def applied(*words: object) -> tuple[Any, str]:
        code, out, err = run("apply", *words, "-o", "v.npy", capsys=capsys)
        assert code == 0, (out, err)
        return np.load("v.npy"), err

    return applied


def of_arrays(depth: Any, **said: Any) -> Any:
    return ao.occlusion(depth, CAMERA, method=ao.Bitmask(radius=0.3), **said)


def test_negative_depth(apply: Any, capsys: pytest.CaptureFixture[str]) -> None:
    right, _ = apply("--depth", "m.npy", *LENS, *RADIUS)
    for values, said in ((np.where(SEEN, Z, np.nan), 0), (np.where(SEEN, Z, 10), 1)):
        np.save("d.npy", -values)
        assert "depth is negative" in refused(capsys, "apply", "--depth", "d.npy", *LENS)
        found, err = apply("--depth", "d.npy", *LENS, *RADIUS, "--depth-kind", "vtk")
        assert np.array_equal(found, right) and err.count("taken as background") == said
    assert np.array_equal(of_arrays(-np.where(SEEN, Z, np.nan), depth_kind="vtk"), right)
    with pytest.raises(ao.FormatError, match="depth is negative"):
        of_arrays(-Z)


@pytest.mark.parametrize("name", ["d.png", "d.npy", "d.pgm", "d.tif"])
def test_millimetres(name: str, apply: Any, capsys: pytest.CaptureFixture[str]) -> None:
    right, _ = apply("--depth", "m.npy", *LENS, *RADIUS)
    mm = np.round(1000 * Z).astype(np.uint16)
    if name == "d.npy":
        np.save(name, mm)
    else:
        Image.fromarray(mm).save(name)
    assert "--depth-scale 0.001 for millimetres" in refused(capsys, "apply", "--depth", name, *LENS)
    found, err = apply("--depth", name, *LENS, *RADIUS, "--depth-scale", "0.001")
    assert (np.abs(found - right) <= 0.05).mean() >= 0.999 and (found[~SEEN] == 1).all() and err == ""
    assert np.array_equal(found, of_arrays(mm, depth_scale=0.001))
    assert np.array_equal(found, of_arrays(Path(name), depth_scale=0.001))


def test_distance_along_the_ray(apply: Any) -> None:
    right, _ = apply("--depth", "m.npy", *LENS, *RADIUS)
    ray = np.linalg.norm(CAMERA.view(SIZE).points(Z), axis=-1).astype(np.float32)
    np.save("r.npy", ray)
    found, _ = apply("--depth", "r.npy", *LENS, *RADIUS, "--depth-kind", "ray")
    assert np.abs(found - right).max() <= 0.01 and np.abs(apply("--depth", "r.npy", *LENS, *RADIUS)[0] - right).max() > 0.02
    assert np.array_equal(found, of_arrays(ray, depth_kind="ray"))


def test_blenders_background(apply: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """With and without a radius; the radius is that of zeros in its place."""
    np.save("b.npy", np.where(SEEN, Z, 1e10).astype(np.float32))
    for radius in (RADIUS, ()):
        right, _ = apply("--depth", "m.npy", *LENS, *radius)
        found, err = apply("--depth", "b.npy", *LENS, *radius, "--json", "b.json")
        assert np.array_equal(found, right) and "hold 1e+10" in err and err.count("\n") == 1
        assert json.loads(Path("b.json").read_text())["warnings"] == [err.removeprefix("ssao-gl: warning: ").strip()]
    assert "(--strict)" in refused(capsys, "apply", "--depth", "b.npy", *LENS, "--strict")
    assert apply("--depth", "b.npy", *LENS, "--strict", "--depth-background", "1e10")[1] == ""


def test_exr_layers(apply: Any, capsys: pytest.CaptureFixture[str]) -> None:
    OpenEXR = pytest.importorskip("OpenEXR")
    grey = {f"ViewLayer.Combined.{name}": np.full_like(Z, 0.5) for name in "RGBA"}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {**grey, "ViewLayer.Depth.Z": Z}) as file:
        file.write("a.exr")
    right, _ = apply("--depth", "m.npy", *LENS, *RADIUS)
    for more in ((), ("--depth-channel", "ViewLayer.Depth.Z")):
        assert np.array_equal(apply("--depth", "a.exr", *LENS, *RADIUS, *more)[0], right)
    assert np.array_equal(of_arrays(Path("a.exr"), depth_channel="ViewLayer.Depth.Z"), right)
    assert "no channel 'Depth'" in refused(capsys, "apply", "--depth", "a.exr", *LENS, "--depth-channel", "Depth")


def test_nothing_to_see_is_no_open_picture(capsys: pytest.CaptureFixture[str]) -> None:
    for values in (0 * Z, np.nan * Z, np.full_like(Z, 1e30)):
        np.save("d.npy", values)
        assert "d.npy: depth has no usable texel" in refused(capsys, "apply", "--depth", "d.npy", *LENS, "-o", "n.npy")
        with pytest.raises(ao.FormatError, match="no usable texel"):
            of_arrays(values)
    np.save("d.npy", 100 * Z)
    assert "depths lie outside 0..1" in refused(capsys, "apply", "--depth", "d.npy", *LENS, "--depth-kind", "window")
    assert not Path("n.npy").exists()


def test_masks(apply: Any) -> None:
    right, _ = apply("--depth", "m.npy", *LENS, *RADIUS)
    np.save("d.npy", np.where(SEEN, Z, 1.2).astype(np.float32))
    for mask in (SEEN.astype(np.uint8) * 255, np.repeat(SEEN[..., None], 4, -1).astype(np.uint8) * 255):
        mask = mask.copy()
        if mask.ndim == 3:
            mask[..., 3] = 255
        Image.fromarray(mask).save("mask.png")
        assert np.array_equal(apply("--depth", "d.npy", *LENS, *RADIUS, "--depth-mask", "mask.png")[0], right)
    assert np.array_equal(of_arrays(np.ma.masked_array(np.where(SEEN, Z, 1.2), ~SEEN)), right)


def test_colour_larger_than_depth(apply: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """Close to what depth of the colour's size gives, and sharp where the colour is."""
    size = (640, 480)
    large = cast(CAMERA, size, flat((0, -0.5, 0), (0, 1, 0), within=2.9), ball_depth((0, -0.2, -2), 0.3)).astype(np.float32)
    color = np.full((480, 640, 3), 90, np.uint8)
    color[large > 0] = 160
    color[(large > 0) & (large < 1.99) & (np.arange(480) < 400)[:, None] & (np.abs(np.arange(640) - 320) < 130)] = [200, 90, 60]
    Image.fromarray(color).save("large.png")
    np.save("large.npy", large)
    lens = ("--intrinsics", "520,520,320,240", "--intrinsics-size", "640x480")
    right, _ = apply("--depth", "large.npy", *lens, *RADIUS)
    found, err = apply("large.png", "--depth", "m.npy", *lens, *RADIUS)
    assert found.shape == (480, 640) and err == ""
    assert np.abs(found - right).mean() < 0.01 and (found[~(large > 0)] == 1).mean() > 0.99
    guessed, err = apply("large.png", "--depth", "m.npy", *lens[:2], *RADIUS)
    assert np.array_equal(guessed, found) and "taken to be for 640x480, as color is" in err
    picture = ao.apply(color, Z, CAMERA, method=ao.Bitmask(radius=0.3))
    assert np.array_equal(picture.visibility, found)
    assert picture.image.shape == color.shape and picture.depth.shape == picture.normal.shape[:2] == (480, 640)
    assert np.array_equal(picture.image, ao.multiply(color, found))
    run("apply", "large.png", "--depth", "m.npy", *lens, *RADIUS, "-o", "a.png", capsys=capsys)
    assert np.abs(load_image("a.png").astype(int) - picture.image).max() <= 1  # of 8 bits' visibility, and of 16


def test_intrinsics_of_another_size(apply: Any) -> None:
    right, _ = apply("--depth", "m.npy", *LENS, *RADIUS)
    other = ("--intrinsics", "520,520,320,240", "--intrinsics-size", "640x480")
    assert np.array_equal(apply("--depth", "m.npy", *other, *RADIUS)[0], right)
    assert "lies outside 160x120; --intrinsics-size says" in apply("--depth", "m.npy", *other[:2], *RADIUS)[1]


def test_photographs_are_upright(apply: Any, capsys: pytest.CaptureFixture[str]) -> None:
    color = np.zeros((120, 160, 3), np.uint8)
    color[:60] = 200
    tags = Image.Exif()
    tags[0x0112] = 6
    Image.fromarray(np.ascontiguousarray(np.rot90(color))).save("t.png", exif=tags)
    assert run("apply", "t.png", "--depth", "m.npy", *LENS, "--strength", "0", "-o", "a.png", capsys=capsys)[0] == 0
    assert np.array_equal(load_image("a.png"), color)


def test_noise(apply: Any) -> None:
    wall = np.full((120, 160), 1.5) + np.random.default_rng(2).normal(0, 0.002, (120, 160))
    np.save("n.npy", wall)
    raw, smooth = (apply("--depth", "n.npy", *LENS, *RADIUS, "--depth-noise", noise)[0] for noise in (0, 0.001))
    assert raw.mean() < 0.97 <= smooth.mean()
    assert np.array_equal(of_arrays(wall, depth_noise=0.001), smooth)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--depth-scale", "0"), "depth scale 0: must be above 0"),
        (("--depth-noise", "-1"), "depth noise -1: must be 0 or more"),
        (("--depth-kind", "window", "--depth-scale", "2"), "window depth has no unit"),
        (("--depth-channel", "Z"), "has no channel 'Z' to choose"),
        (("--intrinsics-size", "big"), "--intrinsics-size big: must be WIDTHxHEIGHT"),
        (("--depth-mask", "gone.png"), "gone.png: no such file"),
        (("--camera", "a.json"), "say how the depth was seen"),
    ],
)
def test_bad_words(words: tuple[str, ...], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert text in refused(capsys, "apply", "--depth", "m.npy", *LENS, *words)
