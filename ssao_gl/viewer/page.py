"""One HTML file that shows a scene: geometry, runtime and pipelines are in it, and it needs no network."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..export.pipeline import Pipeline
from ..export.write import RUNTIME, small_module
from ..io.images import png_bytes
from ..io.pages import page
from ..pipeline.settings import Settings
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth.trace import Truth
from .looks import look_pipeline, offered
from .packing import packed_scene

WEB = Path(__file__).parent / "web"
OWN = "as asked"
"""Name of the look that the caller asked for."""


def shown_looks(settings: Settings | None) -> dict[str, Pipeline]:
    """Return the pipelines of a page by name: the caller's first, where it is none of those that are offered."""
    shown, first = offered(), "bitmask medium"
    if settings is not None:
        same = (name for name, known in shown.items() if known.with_radius(1.0) == settings.with_radius(1.0))
        first = next(same, OWN)
        shown = {first: settings} | shown
    return {name: look_pipeline(one) for name, one in ({first: shown[first]} | shown).items()}


def viewer_module() -> str:
    """Return the runtime and the viewer as the text of one module without imports, which exports both."""
    viewer = (WEB / "viewer.js").read_text("utf-8")
    return small_module(RUNTIME.read_text("utf-8")) + viewer


def viewer_page(scene: Scene, size: Size, settings: Settings | None = None, truths: Mapping[str, Truth] | None = None) -> str:
    """Return the page of a scene.

    size: of the pictures by its cameras, whose shape the view keeps. settings: of the look that it opens with. truths: visibility by
    rays of cameras, by their name. Raises SceneError, SettingsError.
    """
    options = {
        "size": list(size),
        "looks": shown_looks(settings),
        "radius": None if settings is None else settings.method.radius,
        "ambient": (settings or Settings()).shading.ambient,
        "truths": {name: _picture(found) for name, found in (truths or {}).items()},
    }
    return page(
        __package__,
        "view.html",
        title=scene.name or "scene",
        contents=scene.contents,
        module=_script(viewer_module()),
        scene=base64.b64encode(packed_scene(scene, size)).decode(),
        options=base64.b64encode(gzip.compress(json.dumps(options).encode(), mtime=0)).decode(),
    )


def _picture(found: Truth) -> dict[str, Any]:
    """Return visibility as a picture that a page can show."""
    data = base64.b64encode(png_bytes((255 * found.visibility + 0.5).astype("u1"))).decode()
    return {"picture": f"data:image/png;base64,{data}", "radius": found.tracing.radius, "rays": found.spp}


def _script(text: str) -> str:
    """Return the text of a script as it may stand in HTML."""
    return text.replace("</", "<\\/").replace("<!--", "<\\!--")
