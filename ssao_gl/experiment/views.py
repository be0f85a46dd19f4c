"""Where methods are measured: cameras of scenes, at sizes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import SceneError, SettingsError, encodable, near_miss
from ..io.images import SUFFIXES
from ..loaders.camera_files import load_cameras, read_aims
from ..loaders.load import load_scene
from ..loaders.molecules import molecule_kind
from ..loaders.read_options import MoleculeOptions, VolumeOptions
from ..loaders.volume_files import is_volume
from ..scene.camera import Camera
from ..scene.model import Scene
from ..scene.projection import Size
from ..truth.settings import Tracing
from ..truth.store import content_key

AUTOMATIC = "auto"
CAMERAS = ".cam.json"


@dataclass(frozen=True, slots=True)
class SceneReading:
    """How molecules and volumes are read; None for what the camera file beside them aims at, else what is usual."""

    molecule: MoleculeOptions | None = None
    volume: VolumeOptions | None = None

    def of(self, path: Path) -> SceneReading:
        """Return how a file is read: by what was chosen, else by ``assembly`` or ``iso`` of the camera file beside it."""
        aims = read_aims(_camera_file(path))
        volume, molecule = self.volume, self.molecule
        if is_volume(path.name):
            if aims.iso is not None and (volume is None or (volume.iso is None and volume.transfer is None)):
                volume = dataclasses.replace(volume or VolumeOptions(), iso=aims.iso)
            return SceneReading(None, volume)
        if molecule_kind(path.name) is None:
            return SceneReading()
        if aims.assembly is not None and (molecule is None or molecule.assembly is None):
            molecule = dataclasses.replace(molecule or MoleculeOptions(), assembly=aims.assembly)
        return SceneReading(molecule)


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
    reading: SceneReading | None = None
    """How the scene file is read, where it leaves a choice."""

    @property
    def name(self) -> str:
        """One line that tells it from all others."""
        return f"{self.scene}:{self.camera.name} {self.size[0]}x{self.size[1]}"


def load_view_scene(path: Path | None, reading: SceneReading | None = None) -> Scene:
    """Load a scene file as its camera file or ``reading`` says; or the embedded scene. Raises SceneError."""
    if path is not None and path.suffix.lower() in SUFFIXES:
        raise SceneError(f"{path}: a picture or depth array; a report traces rays, and needs a scene")
    if path is not None:
        chosen = (reading or SceneReading()).of(path)
        return load_scene(path, molecule=chosen.molecule, volume=chosen.volume)
    from ..scene.sample_scene import default_scene

    return default_scene()


def views(
    paths: Sequence[Path], cameras: Sequence[str], sizes: Sequence[Size], reading: SceneReading | None = None
) -> list[MeasuredView]:
    """Every camera (or those named) of every scene, at every size; the embedded scene when there are no paths.

    Cameras are those of ``NAME.cam.json`` beside the scene, else the scene's own, else an automatic one. Every scene is
    loaded once, so that one which cannot be fails here and not in the middle of the work. reading: how molecules and volumes
    are read; what it leaves open is what their camera file aims at. Raises SceneError, SettingsError.
    """
    made: list[MeasuredView] = []
    known: list[str] = []
    files: list[Path | None] = [*paths] if paths else [None]
    for name, path in zip(_names(paths), files, strict=True):
        scene = load_view_scene(path, reading)
        for camera in _cameras(path, scene, sizes[0]):
            known.append(camera.name)
            if not cameras or camera.name in cameras:
                made += [
                    MeasuredView(name, path, camera, size, scene.pieces, _content(scene, camera, size), reading)
                    for size in sizes
                ]
    for camera_name in cameras:
        if camera_name not in known:
            names = ", ".join(dict.fromkeys(known))
            raise SettingsError(f"--cameras {camera_name}: no scene has it; there are {names}.{near_miss(camera_name, known)}")
    return sorted(made, key=lambda view: sizes.index(view.size))


def by_scene(some: Sequence[MeasuredView]) -> Iterator[tuple[Scene, list[MeasuredView]]]:
    """Yield views with their scene; one scene is in memory at a time."""
    for path, reading in dict.fromkeys((view.path, view.reading) for view in some):
        yield load_view_scene(path, reading), [view for view in some if (view.path, view.reading) == (path, reading)]


def _content(scene: Scene, camera: Camera, size: Size) -> str:
    return content_key(scene, camera, size, Tracing(radius=camera.ao_radius or scene.default_radius()))


def _names(paths: Sequence[Path]) -> list[str]:
    """Return the file's stem; numbered where two files share it."""
    if not paths:
        return ["embedded"]
    stems = [encodable(_camera_file(path).name.removesuffix(CAMERAS)) for path in paths]
    return [stem if stems.count(stem) == 1 else f"{stem}#{stems[: i + 1].count(stem)}" for i, stem in enumerate(stems)]


def _camera_file(path: Path) -> Path:
    """Return the path of NAME.cam.json for NAME.glb, or for NAME.nii.gz."""
    plain = path.with_suffix("") if path.suffix.lower() == ".gz" else path
    return plain.with_suffix(CAMERAS)


def _cameras(path: Path | None, scene: Scene, size: Size) -> list[Camera]:
    beside = _camera_file(path) if path is not None else None
    if beside is not None and beside.is_file():
        found = load_cameras(beside)
    else:
        found = list(scene.cameras) or [scene.default_camera(size)]
    names = [camera.name or AUTOMATIC for camera in found]
    unique = [name if names.count(name) == 1 else f"{name}{i}" for i, name in enumerate(names)]
    return [dataclasses.replace(camera, name=name) for camera, name in zip(found, unique, strict=True)]
