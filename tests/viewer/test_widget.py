"""The widget in a real notebook kernel, and its front end in a real browser."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import SettingsError
from ssao_gl.scene.sample_scene import default_scene

pytest.importorskip("anywidget")
pytestmark = [
    # Of the notebook's own packages.
    pytest.mark.filterwarnings("default::DeprecationWarning"),
    pytest.mark.filterwarnings("default::nbformat.validator.MissingIDFieldWarning"),
]
MODEL = """(state) => {
    const heard = {};
    const bytes = (text) => new DataView(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
    window.model = {
        state: { ...state, scene: bytes(state.scene) },
        saved: 0,
        get(name) { return this.state[name]; },
        set(name, value) { this.state[name] = value; },
        save_changes() { this.saved++; },
        on(event, listener) { heard[event] = [...(heard[event] ?? []), listener]; },
        send(name, value) { this.state[name] = value; for (const listener of heard[`change:${name}`] ?? []) listener(); },
    };
}"""
CELLS = [
    "import ssao_gl as ao",
    "from ssao_gl.scene.sample_scene import default_scene",
    "widget = ao.widget(default_scene(), (160, 90), method='gtao', height=200)",
    "widget.show = 'visibility'",
    "widget.use(ao.Settings(method=ao.Bitmask(radius=0.4)))",
    "widget",
]


@pytest.fixture(scope="module")
def notebook_state() -> dict[str, Any]:
    """The widget's state as a kernel that ran the cells sent it; the scene as text."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("\n".join(CELLS))])
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3", store_widget_state=True).execute()
    (output,) = (one for one in notebook.cells[0].outputs if one.output_type == "execute_result")
    model_id = output.data["application/vnd.jupyter.widget-view+json"]["model_id"]
    model = notebook.metadata.widgets["application/vnd.jupyter.widget-state+json"]["state"][model_id]
    (scene,) = (buffer["data"] for buffer in model["buffers"] if buffer["path"] == ["scene"])
    return {**model["state"], "scene": scene}


def test_a_kernel_sends_what_was_set(notebook_state: dict[str, Any]) -> None:
    assert notebook_state["look"] == "as asked" and notebook_state["radius"] == 0.4 and notebook_state["show"] == "visibility"
    assert next(iter(notebook_state["looks"])).startswith("gtao") and notebook_state["height"] == 200


def test_the_front_end_draws_it_and_tells_the_camera(notebook_state: dict[str, Any], browser: Any) -> None:
    page = browser.new_page(viewport={"width": 400, "height": 300})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.set_content("<div id='cell'></div>")
    page.evaluate(MODEL, notebook_state)
    page.evaluate("""async (text) => {
        const module = await import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
        window.stop = await module.default.render({ model, el: document.getElementById("cell") });
    }""", notebook_state["_esm"])  # fmt: skip
    page.wait_for_function("model.saved > 0", timeout=60_000)
    assert page.evaluate("[model.get('look'), model.get('radius')]") == ["as asked", 0.4]

    # Python changes a setting: the picture follows.
    bright = "() => { const c = document.querySelector('canvas'); return c.toDataURL().length; }"
    before, saved = page.evaluate(bright), page.evaluate("model.saved")
    page.evaluate("model.send('show', 'normals')")
    page.wait_for_function(f"model.saved > {saved}")
    assert page.evaluate(bright) != before

    # The camera is turned: Python can read it.
    page.locator("canvas").focus()
    page.keyboard.press("ArrowLeft")
    page.wait_for_function("model.get('camera_state').name === ''")
    told = page.evaluate("JSON.stringify(model.get('camera_state'))")
    widget = ao.widget(default_scene(), (160, 90))
    widget.camera_state = json.loads(told)
    own = default_scene().cameras[0]
    assert widget.camera is not None and widget.camera.lens.yfov == pytest.approx(own.lens.yfov)
    moved = widget.camera.pose[:3, 3] - own.pose[:3, 3]
    assert 0.1 < np.linalg.norm(moved) < 3
    with ao.Renderer() as renderer:
        picture = renderer.render(default_scene(), widget.camera, (160, 90), ao.Settings(), aovs=("visibility",))
    assert picture.visibility.std() > 0.05

    # Python places it again.
    widget.camera = own
    page.evaluate("(state) => model.send('camera_state', state)", widget.camera_state)
    x = float(own.pose[0, 3] - widget.middle[0])
    page.wait_for_function(f"Math.abs(model.get('camera_state').pose[12] - ({x})) < 1e-6")
    page.evaluate("stop()")
    assert page.locator("canvas").count() == 0 and not errors
    page.close()


def test_mistakes() -> None:
    widget = ao.widget(default_scene(), (160, 90))
    assert widget.camera is None
    for name, value in (("look", "bitmask best"), ("show", "colour"), ("wipe", 2.0)):
        with pytest.raises(Exception, match=r"best|show|wipe|maximum"):
            setattr(widget, name, value)


def test_without_anywidget_one_line_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    from ssao_gl.viewer import widget

    monkeypatch.setitem(__import__("sys").modules, "anywidget", None)
    widget._kind.cache_clear()
    with pytest.raises(SettingsError, match=r"pip install 'ssao_gl\[notebook\]'"):
        ao.widget(default_scene())
    widget._kind.cache_clear()
