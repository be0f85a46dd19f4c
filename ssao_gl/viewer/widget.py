"""A scene in a notebook: the viewer as a widget, whose settings and camera are those of Python's object."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingsError
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.lens import Orthographic, Perspective
from ..scene.model import Scene
from ..scene.projection import Size
from .looks import look_pipeline
from .packing import packed_camera, packed_scene
from .page import OWN, WEB, shown_looks, viewer_module


def scene_widget(scene: Scene, size: Size, settings: Settings | None, height: int) -> Any:
    """Return a widget that shows a scene; see :func:`ssao_gl.widget`. Raises SettingsError, SceneError."""
    settings = settings or Settings()
    looks = shown_looks(settings)
    options: dict[str, Any] = {"size": list(size), "radius": None, "ambient": settings.shading.ambient, "truths": {}}
    made = _kind()(
        scene=packed_scene(scene, size), options=options, looks=looks, look=next(iter(looks)), radius=settings.method.radius,
        height=height,
    )  # fmt: skip
    made.middle, made.size = scene.bounds.mean(0), size
    return made


@cache
def _kind() -> type:
    """Return the class of the widgets. Raises SettingsError without anywidget."""
    try:
        import anywidget
        import traitlets
    except ImportError as error:
        raise SettingsError("widget: anywidget is not installed; pip install 'ssao_gl[notebook]'") from error

    class SceneWidget(anywidget.AnyWidget):
        """A scene that can be turned. Settings and camera go both ways: assign ``settings`` or ``camera``, or read them."""

        _esm = viewer_module() + (WEB / "widget.js").read_text("utf-8")
        scene = traitlets.Bytes().tag(sync=True)
        options = traitlets.Dict().tag(sync=True)
        looks = traitlets.Dict().tag(sync=True)
        look = traitlets.Unicode().tag(sync=True)
        show = traitlets.Enum(["picture", "visibility", "depth", "normals"], "picture").tag(sync=True)
        compare = traitlets.Enum(["nothing", "no occlusion"], "nothing").tag(sync=True)
        wipe = traitlets.Float(0.5, min=0.0, max=1.0).tag(sync=True)
        strength = traitlets.Float(1.0, min=0.0, max=1.0).tag(sync=True)
        radius = traitlets.Float(None, allow_none=True).tag(sync=True)
        height = traitlets.Int(480, min=100).tag(sync=True)
        camera_state = traitlets.Dict().tag(sync=True)
        middle: NDArray[np.float64]
        size: Size

        @traitlets.validate("look")
        def _known(self, proposal: Any) -> str:
            if self.looks and proposal["value"] not in self.looks:
                raise traitlets.TraitError(f"look '{proposal['value']}': must be one of {', '.join(self.looks)}")
            return str(proposal["value"])

        def use(self, settings: Settings) -> None:
            """Show other settings, as the look "as asked". Raises SettingsError, GraphError."""
            with self.hold_trait_notifications():
                self.looks = {**self.looks, OWN: look_pipeline(settings)}
                self.look = OWN
                self.radius = settings.method.radius

        @property
        def camera(self) -> Camera | None:
            """The camera as it is now, in scene units; None until the widget is shown."""
            state = self.camera_state
            return _camera(state, self.middle) if "range" in state else None

        @camera.setter
        def camera(self, camera: Camera) -> None:
            self.camera_state = packed_camera(camera, self.size, self.middle)

    return SceneWidget


def _camera(state: dict[str, Any], middle: NDArray[np.float64]) -> Camera:
    """Return the camera of a state that the browser sent."""
    pose = np.array(state["pose"], np.float64).reshape(4, 4).T
    pose[:3, 3] += middle
    near, far = state["range"]
    name = str(state.get("name", ""))
    if state.get("matrix"):
        return dataclasses.replace(Camera.from_matrix(np.reshape(state["matrix"], (4, 4)).T, pose), name=name)
    if state.get("height"):
        return Camera(Orthographic(state["height"], near, far), pose, name)
    return Camera(Perspective(state["yfov"], near, far), pose, name)
