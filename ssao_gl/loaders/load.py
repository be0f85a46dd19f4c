"""Scene files, read by their format; whatever goes wrong is one line."""

from __future__ import annotations

import gc
import logging
import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SceneError, encodable, one_line
from ..io.atomic import why_unreadable
from ..scene.model import Scene
from .finished import finished
from .molecules import molecule_kind, read_molecule
from .notes import Notes
from .read_options import MoleculeOptions, ReadOptions, VolumeOptions
from .up_axis import up_direction
from .volume_files import VOLUMES, is_volume, read_volume
from .xyz_spheres import read_xyz_spheres

LARGE = 10**5
"""Triangles from which memory is given back at once."""


def load_scene(
    path: Path | str,
    *,
    crease: float = math.radians(40),
    up: str = "auto",
    animation: str | None = None,
    time: float = 0.0,
    point_size: float | None = None,
    molecule: MoleculeOptions | None = None,
    volume: VolumeOptions | None = None,
) -> Scene:
    """Read a scene file: meshes (GLB, glTF, OBJ, PLY, STL, OFF ...), a molecule (PDB, mmCIF; also .gz) or a volume (NRRD, NIfTI).

    Nothing outside its folder is read, nothing is fetched.

    crease: faces of meshes without normals that meet at more than this angle (radians) keep a sharp edge; 0 shades flat.
    up: which axis of the file points upwards for automatic cameras, x, y, z, or auto by format. animation, time: an animation
    of a glTF file by name or number, and a moment of it in seconds; None for the file's rest pose. point_size: diameter of
    points in scene units, None for one that closes their surface. molecule, volume: how one is read, if it is one. What is
    dropped or guessed is logged once, and kept in ``Scene.warnings``. Raises SceneError, in one line, for anything that cannot
    be read or drawn.
    """
    path, notes = Path(path), Notes()
    options = ReadOptions(
        crease=crease,
        animation=animation,
        time=time,
        point_size=point_size,
        molecule=molecule or MoleculeOptions(),
        volume=volume or VolumeOptions(),
    )
    with reading(path):
        scene = _read(path, up, options, notes)
    notes.say(path)
    if scene.triangles > LARGE:
        gc.collect()  # meshes of trimesh refer to themselves, and would stay beside what is uploaded now
    return scene


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn whatever reading a scene file leads into to a SceneError of one line. Raises one for what is no file, too."""
    if reason := why_unreadable(path):
        raise SceneError(f"{path}: {reason}; expected a scene file")
    try:
        with _quiet():
            yield
    except SceneError as error:
        raise SceneError(f"{path}: {one_line(error, 500)}") from error
    except (KeyboardInterrupt, SystemExit):
        raise
    except MemoryError as error:
        raise SceneError(f"{path}: needs more memory than there is") from error
    except BaseException as error:  # the readers raise whatever a broken file leads them into
        brief = one_line(error, 200) or "its data contradict each other"
        raise SceneError(
            f"{path}: not a readable {'volume' if is_volume(path.name) else 'mesh'} file ({type(error).__name__}: {brief}); is it truncated or broken?"
        ) from error


def _read(path: Path, up: str, options: ReadOptions, notes: Notes) -> Scene:
    if is_volume(path.name):
        if options.animation is not None:
            raise SceneError(f"has no animations, as no volume has; leave out '{options.animation}'")
        volume = read_volume(path, options.volume, notes)
        return finished(Scene(up=up_direction(up, "volume"), name=encodable(path.name), volumes=[volume]), notes)
    if options.volume != VolumeOptions():
        raise SceneError(f"is no volume: iso levels, transfer functions and frames are for {', '.join(VOLUMES)} files")
    kind, spheres = molecule_kind(path.name), []
    if kind is not None:
        spheres = [*read_molecule(path, kind, options.molecule, notes)]
    elif path.suffix.lower() == ".xyz" and (found := read_xyz_spheres(path, options.molecule)):
        kind, spheres = "xyz", [found]
    if kind is not None:
        return finished(Scene((), up=up_direction(up, kind), name=encodable(path.name), spheres=spheres), notes)
    from . import mesh_files

    loaded = mesh_files.read(path, options, notes)
    scene = Scene(loaded.meshes, loaded.cameras, up_direction(up, loaded.kind), encodable(path.name), lamps=loaded.lamps)
    return finished(scene, notes)


class _quiet(warnings.catch_warnings):
    """Silence what trimesh and numpy log while they read a broken file: the error says it."""

    def __enter__(self) -> Any:
        entered = super().__enter__()
        warnings.simplefilter("ignore")
        self._logger = logging.getLogger("trimesh")
        self._level = self._logger.level
        self._logger.setLevel(logging.CRITICAL + 1)
        self._errors = np.seterr(all="ignore")
        return entered

    def __exit__(self, *exception: Any) -> None:
        np.seterr(**self._errors)
        self._logger.setLevel(self._level)
        super().__exit__(*exception)
