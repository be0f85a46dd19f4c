"""Where methods are measured: cameras of scenes, at sizes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import SceneError, SettingsError, encodable, near_miss
from ..io.images import SUFFIXES
from ..loaders.camera_files import file_assembly, load_cameras
from ..loaders.load import load_scene
from ..loaders.read_options import MoleculeOptions
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth.settings import Tracing
from ..truth.store import content_key

AUTOMATIC = "auto"
CAMERAS = ".cam.json"


@dataclass(frozen=True, eq=False, slots=True)
class MeasuredView:
    """A camera of a scene, at a size (width, height) in pixels. ``path`` is None for the embedded scene."""

    scene: str
    path: Path | None
    camera: Camera
    size: Size
    triangles: int
    """Spheres and volumes counted like them."""
    content: str
    """Hash of the scene, the camera and the size."""

    @property
    def name(self) -> str:
        """One line that tells it from all others."""
        return f"{self.scene}:{self.camera.name} {self.size[0]}x{self.size[1]}"


def load_view_scene(path: Path | None) -> Scene:
    """Load a scene file, a molecule in the assembly that its camera file names; or the embedded scene. Raises SceneError."""
    if path is not None and path.suffix.lower() in SUFFIXES:
        raise SceneError(f"{path}: a picture or depth array; a report traces rays, and needs a scene")
    if path is not None:
        return load_scene(path, molecule=MoleculeOptions(assembly=file_assembly(_beside(path))))
    from ..scene.sample_scene import default_scene

    return default_scene()


def views(paths: Sequence[Path], cameras: Sequence[str], sizes: Sequence[Size]) -> list[MeasuredView]:
    """Every camera (or those named) of every scene, at every size; the embedded scene when there are no paths.

    Cameras are those of ``NAME.cam.json`` beside the scene, else the scene's own, else an automatic one. Every scene is
    loaded once, so that one which cannot be fails here and not in the middle of the work. Raises SceneError, SettingsError.
    """
    made: list[MeasuredView] = []
    known: list[str] = []
    files: list[Path | None] = [*paths] if paths else [None]
    for name, path in zip(_names(paths), files, strict=True):
        scene = load_view_scene(path)
        for camera in _cameras(path, scene, sizes[0]):
            known.append(camera.name)
            if not cameras or camera.name in cameras:
                made += [MeasuredView(name, path, camera, size, scene.pieces, _content(scene, camera, size)) for size in sizes]
    for camera_name in cameras:
        if camera_name not in known:
            names = ", ".join(dict.fromkeys(known))
            raise SettingsError(f"--cameras {camera_name}: no scene has it; there are {names}.{near_miss(camera_name, known)}")
    return sorted(made, key=lambda view: sizes.index(view.size))


def by_scene(some: Sequence[MeasuredView]) -> Iterator[tuple[Scene, list[MeasuredView]]]:
    """Yield views with their scene; one scene is in memory at a time."""
    for path in dict.fromkeys(view.path for view in some):
        yield load_view_scene(path), [view for view in some if view.path == path]


def _content(scene: Scene, camera: Camera, size: Size) -> str:
    return content_key(scene, camera, size, Tracing(radius=camera.ao_radius or scene.default_radius()))


def _names(paths: Sequence[Path]) -> list[str]:
    """Return the file's stem; numbered where two files share it."""
    if not paths:
        return ["embedded"]
    stems = [encodable(path.stem) for path in paths]
    return [stem if stems.count(stem) == 1 else f"{stem}#{stems[: i + 1].count(stem)}" for i, stem in enumerate(stems)]


def _beside(path: Path) -> Path:
    """Return where a scene's camera file lies."""
    return path.with_suffix(CAMERAS)


def _cameras(path: Path | None, scene: Scene, size: Size) -> list[Camera]:
    if path is not None and _beside(path).is_file():
        found = load_cameras(_beside(path))
    else:
        found = list(scene.cameras) or [scene.default_camera(size)]
    names = [camera.name or AUTOMATIC for camera in found]
    unique = [name if names.count(name) == 1 else f"{name}{i}" for i, name in enumerate(names)]
    return [dataclasses.replace(camera, name=name) for camera, name in zip(found, unique, strict=True)]
