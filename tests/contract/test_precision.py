"""Mobile precision: pictures near those of high precision, with mediump where the driver has it and rounded by hand on all."""

from __future__ import annotations

import dataclasses

import moderngl
import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.gl.programs import Program
from ssao_gl.glsl import preprocess
from ssao_gl.glsl.half_floats import emulate_half_floats
from ssao_gl.pipeline.presets import settings_from
from ssao_gl.pipeline.settings import PRECISIONS
from ssao_gl.scene.model import Scene
from ssao_gl.stress import finite_check

from ..conftest import openable
from ..shapes import camera, plane

SIZE = (96, 72)
HALF = {"MOBILE": 1, "HALF": 1}
CHOICES = [("bitmask", "draft"), ("bitmask", "medium"), ("bitmask", "high"), ("alchemy", "medium")]


def draw(renderer: ao.Renderer, settings: ao.Settings, scene: Scene, cam: ao.Camera) -> tuple[np.ndarray, np.ndarray]:
    """Visibility in steps of 1/255, and the picture; nothing on the way to them may be infinite or NaN."""
    watched = dataclasses.replace(settings, method=finite_check.with_finite_check(settings.method))
    assert renderer.render(scene, cam, SIZE, watched, aovs=("visibility",), checked=True).visibility.min() == 1
    picture = renderer.render(scene, cam, SIZE, settings, checked=True)
    return np.rint(picture.visibility * 255), picture.image.astype(int)


@pytest.mark.parametrize(("name", "preset"), CHOICES)
def test_mobile_is_near_high(
    renderer: ao.Renderer, provider: str, name: str, preset: str, embedded: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    high = settings_from(method_name=name, preset_name=preset)
    mobile, cam = dataclasses.replace(high, precision="mobile"), embedded.cameras[0]
    seen, image = draw(renderer, high, embedded, cam)
    lower = [draw(renderer, mobile, embedded, cam)]  # mediump where the driver has it
    monkeypatch.setitem(PRECISIONS, "mobile", HALF)  # type: ignore[arg-type]
    with ao.Renderer(provider) as fresh:
        lower.append(draw(fresh, mobile, embedded, cam))
    for low, low_image in lower:
        assert np.abs(seen - low).max() <= 2
        assert np.abs(image - low_image)[seen == low].max() <= 1
    assert (image != lower[1][1]).any()  # something was rounded


@pytest.mark.gl
@pytest.mark.parametrize("tilt", [0.6, 1.4])
@pytest.mark.parametrize(("name", "preset"), CHOICES)
def test_a_plane_stays_open(name: str, preset: str, tilt: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRECISIONS, "mobile", HALF)  # type: ignore[arg-type]
    settings = settings_from(method_name=name, preset_name=preset, assignments=["precision=mobile", "radius=0.8"])
    with ao.Renderer(openable()[0]) as fresh:
        assert draw(fresh, settings, plane(tilt), camera())[0].min() >= 254


PROBE = """
uniform float u_x;
void main() {
    LOW float x = u_x;
    LOW float square = u_x * u_x;
    LOW float rest = u_x - 0.1;
    rest -= x;
    LOW vec2 sum = vec2(x);
    sum += vec2(0.1, 0.0);
    frag_color = vec4(x, square, rest, sum.x);
}
"""


def test_rounding_is_that_of_half_floats(renderer: ao.Renderer) -> None:
    ctx, random = renderer.ctx, np.random.default_rng(1)
    scale = 2.0 ** random.uniform(-30, 18, 60)
    values = np.array([0, 1, -1, 2049, 2051, 65504, 65519, 65520, -7e4, 1e30, 300, 6e-8, *scale, *-scale], np.float32)
    header = preprocess.build("composite.frag", {"HALF": 1}, ctx.dialect).text.split("// An sRGB")[0]
    fragment = preprocess.ShaderSource(emulate_half_floats(header + PROBE), ())
    with ctx.current():
        program = Program(ctx, preprocess.build("fullscreen.vert", {}, ctx.dialect), fragment, "probe")
        target = ctx.mgl.texture((1, 1), 4, dtype="f4")
        frame = ctx.mgl.framebuffer([target])
        corner = ctx.mgl.buffer(np.array([-1, -1, 3, -1, -1, 3], "f4").tobytes())
        triangle = ctx.mgl.vertex_array(program.mgl, [(corner, "2f", "a_corner")])
        rows = []
        for value in values:
            program.set({"u_x": float(value)})
            frame.use()
            triangle.render(moderngl.TRIANGLES)
            rows.append(np.frombuffer(frame.read(components=4, dtype="f4"), np.float32))
        for made in (triangle, corner, frame, target, program):
            made.release()
    with np.errstate(over="ignore", invalid="ignore"):
        x = values.astype(np.float16)
        rest = ((values - np.float32(0.1)).astype(np.float16) - x.astype(np.float32)).astype(np.float16)
        total = (x.astype(np.float32) + np.float32(0.1)).astype(np.float16)
        expected = np.stack([x, (values * values).astype(np.float16), rest, total], -1).astype(np.float32)
    finite = np.isfinite(x)  # infinity less infinity is whatever the driver makes of it
    np.testing.assert_array_equal(np.stack(rows)[finite], expected[finite])
    np.testing.assert_array_equal(np.stack(rows)[~finite, :2], expected[~finite, :2])
    overflow = expected[values == 300][0]
    assert np.isinf(overflow[1])


def test_precision_is_a_setting_of_its_own() -> None:
    assert settings_from(assignments=["precision=mobile"]).precision == "mobile"
    assert settings_from({"precision": "mobile"}).table()["precision"] == "mobile"
    with pytest.raises(ao.SettingsError, match=r"precision.*high.*mobile"):
        settings_from(assignments=["precision=low"])
