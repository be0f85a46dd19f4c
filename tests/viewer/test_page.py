"""The page of a scene in a real browser, by mouse and keyboard, and the widget in a real notebook kernel."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.scene.sample_scene import default_scene
from ssao_gl.truth.settings import Tracing
from ssao_gl.truth.trace import trace
from ssao_gl.viewer.page import viewer_page

SIZE = (320, 180)


@pytest.fixture(scope="module")
def shown(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A page from a file, of the embedded scene with rays."""
    scene = default_scene()
    camera = scene.cameras[0]
    path = tmp_path_factory.mktemp("page") / "view.html"
    path.write_text(viewer_page(scene, SIZE, None, {camera.name: trace(scene, camera, SIZE, Tracing(spp=4))}), "utf-8")
    page = browser.new_page(viewport={"width": 640, "height": 360}, color_scheme="dark")
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    page.on(
        "request",
        lambda request: errors.append(request.url) if not request.url.startswith(("file:", "data:", "blob:")) else None,
    )
    page.goto(path.as_uri())
    page.wait_for_function("globalThis.viewer?.frames > 0", timeout=60_000)
    yield page
    page.close()
    assert not errors


def pixels(page: Any) -> np.ndarray:
    """What the canvas shows, once it is drawn: (h, w, 3) uint8."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    data = page.evaluate("viewer.canvas.toDataURL().split(',')[1]")
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB"))


def state(page: Any, **values: Any) -> np.ndarray:
    page.evaluate("(values) => viewer.set(values)", values)
    return pixels(page)


def test_buffers_are_those_of_python(shown: Any) -> None:
    """Visibility and depth beside a render of the same camera."""
    shown.evaluate("viewer.takeCamera(0)")
    scene = default_scene()
    with ao.Renderer() as renderer:
        picture = renderer.render(scene, scene.cameras[0], SIZE, ao.Settings(), aovs=("visibility", "depth"))
    canvas = shown.evaluate("[viewer.canvas.width, viewer.canvas.height]")
    seen = Image.fromarray(state(shown, show="visibility", compare="nothing")).convert("L").resize(SIZE, Image.Resampling.BOX)
    covered = picture.depth > 0
    error = np.asarray(seen)[covered] / 255 - picture.visibility[covered]
    assert canvas[0] / canvas[1] == pytest.approx(SIZE[0] / SIZE[1], rel=0.01)
    assert abs(error.mean()) < 0.02 and np.sqrt((error**2).mean()) < 0.06
    assert (state(shown, show="depth").max(-1) > 0).mean() == pytest.approx(covered.mean(), abs=0.02)
    normals = state(shown, show="normals")
    assert (normals[normals.max(-1) > 0][:, 2] >= 126).mean() > 0.97, "normals are turned to the viewer"


def test_wipe_shows_rays_at_the_camera_alone(shown: Any) -> None:
    shown.evaluate("viewer.takeCamera(0)")
    before = state(shown, show="visibility", compare="nothing")
    shown.wait_for_function("viewer.truthTexture() || viewer.changed()")
    wiped = state(shown, compare="rays", wipe=0.5)
    half = before.shape[1] // 2
    assert (before[:, half + 2 :] == wiped[:, half + 2 :]).all() and (
        before[:, : half - 2] != wiped[:, : half - 2]
    ).mean() > 0.1
    assert shown.locator(".edge").is_visible() and "rays a pixel" in shown.locator("[role=status]").inner_text()
    shown.evaluate("viewer.eye.turn(0.3, 0); viewer.changed()")
    pixels(shown)
    assert not shown.locator(".edge").is_visible() and "not traced" in shown.locator("[role=status]").inner_text()
    state(shown, compare="nothing")


def test_mouse_and_wheel_move_the_camera(shown: Any) -> None:
    shown.evaluate("viewer.takeCamera(0)")
    first, pose = state(shown, show="picture"), shown.evaluate("viewer.eye.pose")
    shown.mouse.move(200, 200)
    shown.mouse.down()
    shown.mouse.move(260, 220, steps=3)
    shown.mouse.up()
    turned, turned_pose = pixels(shown), shown.evaluate("viewer.eye.pose")
    assert (turned != first).mean() > 0.05 and turned_pose != pose
    away = "Math.hypot(...viewer.eye.pose.slice(12, 15).map((v, i) => v - viewer.eye.target[i]))"
    before = shown.evaluate(away)
    shown.mouse.wheel(0, -300)
    pixels(shown)
    assert shown.evaluate(away) < 0.9 * before
    target = shown.evaluate("viewer.eye.target")
    shown.mouse.down(button="right")
    shown.mouse.move(300, 240)
    shown.mouse.up(button="right")
    assert shown.evaluate("viewer.eye.target") != target


def test_keys(shown: Any) -> None:
    shown.locator("canvas").focus()
    shown.keyboard.press("Home")
    first = state(shown, show="picture", occlusion=True, compare="nothing")
    assert not shown.evaluate("viewer.eye.moved")
    shown.keyboard.press("o")
    assert (pixels(shown).astype(int) >= first.astype(int) - 1).all() and (pixels(shown) != first).any(), (
        "without occlusion all is lighter"
    )
    shown.keyboard.press("o")
    shown.keyboard.press("v")
    assert shown.evaluate("viewer.state.show") == "visibility"
    shown.keyboard.press("c")
    shown.keyboard.press("[")
    assert shown.evaluate("[viewer.state.compare, viewer.state.wipe]") == ["no occlusion", 0.45]
    shown.keyboard.press("ArrowLeft")
    assert shown.evaluate("viewer.eye.moved")
    for key in ("Home", "v", "v", "v", "c", "c"):
        shown.keyboard.press(key)
    assert (pixels(shown) == first).all(), "and back"


def test_controls_change_what_is_seen(shown: Any) -> None:
    shown.evaluate("viewer.takeCamera(0)")
    medium = state(shown, show="visibility", compare="nothing", look="bitmask medium")
    shown.locator("input[name=radius]").fill("2")
    wide = pixels(shown)
    assert wide.mean() < medium.mean() - 2
    looks = shown.locator("select[name='method and preset']")
    for look in ("gtao medium", "lecture 4"):
        looks.select_option(look)
        assert (pixels(shown) != wide).mean() > 0.05 and shown.locator("[role=status]").inner_text() == ""
    looks.select_option("bitmask medium")
    shown.evaluate("viewer.set({ radius: null })")
    assert (pixels(shown) == medium).all()


def test_a_lost_context_comes_back(shown: Any) -> None:
    shown.evaluate("viewer.takeCamera(0)")
    before = state(shown, show="visibility", look="bitmask medium")
    shown.evaluate("window.loser = viewer.gl.getExtension('WEBGL_lose_context'); loser.loseContext()")
    shown.evaluate("new Promise((done) => setTimeout(done, 100))")
    shown.evaluate("loser.restoreContext()")
    shown.wait_for_function("!viewer.gl.isContextLost()")
    shown.evaluate("new Promise((done) => setTimeout(done, 100))")
    assert (pixels(shown) == before).all()


def test_a_page_of_any_width_stays_usable(shown: Any, tmp_path: Path) -> None:
    for width, height in ((360, 640), (900, 300)):
        shown.set_viewport_size({"width": width, "height": height})
        box = shown.locator("canvas").bounding_box()
        assert (
            box["width"] <= width
            and box["height"] <= height
            and box["width"] / box["height"] == pytest.approx(16 / 9, rel=0.02)
        )
        assert shown.evaluate("document.documentElement.scrollWidth") <= width
    shown.set_viewport_size({"width": 640, "height": 360})
