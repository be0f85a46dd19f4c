"""Hash of everything that decides the pixels of a picture that is drawn in several steps."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from ..io.fingerprint import add_arrays, add_thing, code_fingerprint
from ..pipeline.settings import Settings
from ..render.renderer import Renderer
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size


def picture_identity(renderer: Renderer, scene: Scene, camera: Camera, size: Size, settings: Settings, facts: list[Any]) -> str:
    """Return the hash of the code, the driver, the scene, the camera, the size, the settings, and ``facts`` (JSON values)."""
    ctx = renderer.ctx
    driver = [ctx.provider, ctx.renderer, ctx.version]
    every = [
        code_fingerprint(),
        driver,
        size,
        settings.table(),
        scene.name,
        scene.background,
        camera.name,
        camera.ao_radius,
        facts,
    ]
    digest = hashlib.sha256(json.dumps(every, sort_keys=True).encode())
    add_arrays(digest, (camera.lens.matrix(size), camera.pose))
    for thing in scene.things:
        add_thing(digest, thing, normals=True, colors=True)
    return digest.hexdigest()
