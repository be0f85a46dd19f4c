"""Small pictures of many scenes, one after the other; what cannot be drawn is a tile, too, that says why."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, SsaoError, encodable, one_line
from ..loaders.as_scene import as_scene
from ..loaders.mesh_files import formats, kind_of
from ..loaders.molecules import KINDS
from ..loaders.volume_files import is_volume
from ..pipeline.settings import Settings
from ..render.renderer import Renderer
from ..scene.model import Scene
from ..scene.projection import Size

SAMPLES = 2
"""Along each side of a pixel, at least, against stairs at edges."""


@dataclass(frozen=True, eq=False)
class Thumbnail:
    """A scene seen whole. image: (h, w, 3 or 4) uint8 sRGB; None where ``fault`` says why there is none, or where it is no longer needed."""

    name: str
    image: NDArray[np.uint8] | None
    fault: str = ""
    contents: str = ""
    warnings: tuple[str, ...] = ()


def thumbnails(
    renderer: Renderer, sources: Iterable[Any], size: Size, settings: Callable[[Scene], Settings], *, up: str = "auto"
) -> Iterator[Thumbnail]:
    """Yield a picture of ``size`` (width, height) of each source: a path, or what :func:`ssao_gl.as_scene` takes.

    settings: of a scene, once it is known. up: as of :func:`ssao_gl.as_scene`. A source that cannot be read or drawn does
    not end the others.
    """
    for number, source in enumerate(sources):
        name = encodable(Path(source).name) if isinstance(source, str | Path) else f"{type(source).__name__} {number}"
        try:
            scene = as_scene(source, up)
            picture = renderer.render(scene, None, size, _smooth(settings(scene)), aovs=("image",))
        except SsaoError as error:
            yield Thumbnail(name, None, one_line(error, 300).removeprefix(f"{source}: "))
        except MemoryError:
            yield Thumbnail(name, None, "needs more memory than there is")
        else:
            yield Thumbnail(scene.name or name, picture.image, "", scene.contents, scene.warnings)


def _smooth(settings: Settings) -> Settings:
    return dataclasses.replace(settings, supersample=max(settings.supersample, SAMPLES))


def on_ground(settings: Settings, background: str) -> Settings:
    """Return settings whose pictures have that background. Raises SettingsError."""
    return dataclasses.replace(settings, shading=dataclasses.replace(settings.shading, background=background))


def scene_files(paths: Iterable[Path]) -> list[Path]:
    """Return the files that are named, and, of folders, the scene files in them by name. Raises SceneError for none."""
    found: list[Path] = []
    for path in paths:
        if not path.is_dir():
            found.append(path)
            continue
        inside = [file for file in sorted(path.iterdir()) if file.is_file() and _is_scene(file.name)]
        if not inside:
            raise SceneError(f"{path}: no scene file lies in this folder; expected files that end in .glb, .obj, .stl ...")
        found += inside
    if not found:
        raise SceneError("no scene file is given; expected files or a folder of them")
    return found


def _is_scene(name: str) -> bool:
    if name.startswith("."):
        return False
    kind = name.lower().removesuffix(".gz").rpartition(".")[2]
    return is_volume(name) or kind in KINDS or kind_of(name) in formats()
