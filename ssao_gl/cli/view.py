"""``ssao-gl view``: a scene as one page for the browser."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..io.atomic import atomic_write
from ..loaders.camera_files import load_cameras
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth.settings import Tracing
from ..truth.trace import Truth, trace
from ..viewer.page import viewer_page
from .cache_options import CacheOptions
from .help_pages import OUTPUT, RAYS
from .options import LookOptions, ViewOptions
from .output import check_output, counted, say
from .tokens import WHOLE


def view(
    scene: Path | None = None,
    *,
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], group=OUTPUT, allow_leading_hyphen=True, help="HTML file.")
    ] = Path("view.html"),
    truth: Annotated[
        bool,
        Parameter(group=RAYS, negative="", help="Trace what each camera sees, to compare with; needs the extra truth."),
    ] = False,
    spp: Annotated[int, WHOLE, Parameter(group=RAYS, help="Of --truth: rays a pixel, rounded up to a power of two.")] = 64,
    look: LookOptions = LookOptions(),
    cache: CacheOptions = CacheOptions(),
    view: ViewOptions = ViewOptions(),
) -> int:
    """Write one HTML file that shows a scene in the browser: orbit, methods, presets, before and after, buffers.

    Parameters
    ----------
    scene
        Scene file: meshes (without textures) or molecules. Without it: the embedded scene.
    """
    check_output("-o", output, (".html", ".htm"))
    size = view.pixels()
    settings = look.settings()
    loaded = view.load(scene)
    settings = look.settled(settings, loaded.default_radius)
    cameras = _cameras(loaded, view, size)
    shown = dataclasses.replace(loaded, cameras=cameras)
    truths = _truths(shown, settings.method.radius, size, spp, cache) if truth else {}
    text = viewer_page(shown, size, settings, truths)
    with atomic_write(output) as temporary:
        temporary.write_text(text, "utf-8")
    say(
        f"{output}: {loaded.name}, {loaded.contents}, {len(cameras)} camera{'s' * (len(cameras) > 1)}, {output.stat().st_size / 1e6:.1f} MB"
    )
    return 0


def _cameras(scene: Scene, view: ViewOptions, size: Size) -> list[Camera]:
    """Return the cameras of the page: the chosen one, or all of its file, then the scene's own."""
    if view.camera is None:
        return [view.choose(scene), *scene.cameras[1:]]
    specs = [view.camera]
    if Path(view.camera).exists():
        specs = [f"{view.camera}:{index}" for index in range(len(load_cameras(view.camera, size)))]
    return [*(dataclasses.replace(view, camera=spec).choose(scene) for spec in specs), *scene.cameras]


def _truths(scene: Scene, radius: float | None, size: Size, spp: int, cache: CacheOptions) -> dict[str, Truth]:
    found = {}
    for camera in scene.cameras:
        with counted(f"tracing {camera.name}") as progress:
            tracing = Tracing(radius=radius, spp=spp)
            found[camera.name or "camera"] = trace(scene, camera, size, tracing, cache=cache.folder(), progress=progress)
    return found
