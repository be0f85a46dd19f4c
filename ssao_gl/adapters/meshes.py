"""Meshes and scenes of trimesh, and the files that it reads."""

from __future__ import annotations

import logging
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera, Perspective
from ..errors import SceneError
from ..normals import crease_normals
from ..scene import Draw, Scene

if TYPE_CHECKING:
    import trimesh

Z_UP = frozenset({".stl", ".3mf", ".ply", ".off", ".xyz", ".dxf"})
"""Formats in which z is usually up; in all others y is. It only turns automatic views."""

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
DEFAULT_COLOR = (0.8, 0.8, 0.8)
CREASE = math.radians(40)


def load(path: Path | str, *, crease: float = CREASE, up: str = "auto") -> Scene:
    """Read a mesh or scene file (GLB, glTF, OBJ, PLY, STL, OFF ...). Nothing outside its folder is read, nothing is fetched.

    crease: faces of meshes without normals that meet at more than this angle (radians) keep a sharp edge; 0 shades flat.
    up: ``"x"``, ``"y"``, ``"z"``, or ``"auto"`` by format. Raises SceneError, in one line, for anything unreadable.
    """
    path = Path(path)
    if not path.is_file():
        raise SceneError(f"{path}: {'is a folder, not a scene file' if path.is_dir() else 'no such file'}")
    if path.stat().st_size == 0:
        raise SceneError(f"{path}: the file is empty")
    import trimesh

    suffix = path.suffix.lower().lstrip(".")
    known = trimesh.available_formats()
    if suffix not in known:
        raise SceneError(f"{path}: unknown mesh format '.{suffix}'; this trimesh reads {', '.join(sorted(known))}")
    try:
        with _quiet():
            loaded = trimesh.load_scene(path, allow_remote=False)
        return from_trimesh(loaded, crease=crease, up=_up(up, path.suffix.lower()), name=path.name)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # the readers raise whatever a broken file leads them into
        brief = " ".join(str(error).split())[:200]
        raise SceneError(f"{path}: not a readable {suffix} file ({type(error).__name__}: {brief})") from error


def from_trimesh(
    source: trimesh.Trimesh | trimesh.Scene,
    *,
    crease: float = CREASE,
    up: tuple[float, float, float] = AXES["y"],
    name: str = "",
) -> Scene:
    """A :class:`~ssao_gl.Scene` from a ``trimesh.Trimesh`` or ``trimesh.Scene``; instances share one geometry."""
    import trimesh

    if isinstance(source, trimesh.Trimesh):
        source = trimesh.Scene(source)
    if not isinstance(source, trimesh.Scene):
        raise SceneError(f"expected a trimesh.Trimesh or trimesh.Scene, got {type(source).__name__}")
    places: dict[str, list[NDArray[np.float64]]] = {}
    for node in source.graph.nodes_geometry:
        matrix, geometry = source.graph.get(node)
        places.setdefault(str(geometry), []).append(np.asarray(matrix, np.float64))
    draws = []
    for key, transforms in places.items():
        geometry = source.geometry.get(key)
        if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces):
            draws.append(_draw(geometry, np.stack(transforms), key, crease))
    if not draws:
        raise SceneError("holds no triangles")
    return Scene(draws, cameras=_cameras(source), up=up, name=name)


def _draw(mesh: trimesh.Trimesh, transforms: NDArray[np.float64], name: str, crease: float) -> Draw:
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise SceneError(f"mesh '{name}': a triangle names vertex {faces.max()}, but there are only {len(vertices)}")
    with np.errstate(over="ignore"):
        positions = vertices.astype(np.float32)
    triangles = faces.astype(np.uint32)
    color, vertex_colors = _colors(mesh)
    normals = None
    if "vertex_normals" in mesh._cache:  # read from the file, not computed by trimesh
        normals = np.asarray(mesh.vertex_normals, np.float32)
    elif crease > 0 and np.isfinite(positions).all():
        positions, triangles, normals, source = crease_normals(positions, triangles, crease)
        vertex_colors = None if vertex_colors is None else vertex_colors[source]
    return Draw(positions, triangles, normals, color, vertex_colors, transforms, name)


def _colors(mesh: Any) -> tuple[tuple[float, float, float], NDArray[np.uint8] | None]:
    """(base colour, vertex colours) in sRGB. A texture is sampled at the vertices."""
    visual, white = mesh.visual, (1.0, 1.0, 1.0)
    if visual is None or not visual.defined:
        return DEFAULT_COLOR, None
    if visual.kind == "vertex":
        return white, np.asarray(visual.vertex_colors, np.uint8)
    if visual.kind == "face":  # one colour a face needs vertices of its own; the mean of the faces around is close
        return white, np.asarray(visual.to_color().vertex_colors, np.uint8) if hasattr(visual, "to_color") else _face_mean(mesh)
    material = getattr(visual, "material", None)
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if image is not None and getattr(visual, "uv", None) is not None and len(visual.uv) == len(mesh.vertices):
        return white, np.asarray(visual.to_color().vertex_colors, np.uint8)
    factor = getattr(material, "baseColorFactor", None)
    if factor is not None:  # glTF's factors are linear
        return _encode(np.asarray(factor, np.float64)[:3] / 255), None
    main = getattr(material, "main_color", None)
    return (DEFAULT_COLOR if main is None else tuple(float(c) / 255 for c in main[:3])), None  # type: ignore[return-value]


def _face_mean(mesh: Any) -> NDArray[np.uint8]:
    colors = np.asarray(mesh.visual.face_colors, np.float64)
    total = np.zeros((len(mesh.vertices), 4))
    for corner in range(3):
        np.add.at(total, mesh.faces[:, corner], colors)
    count = np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices))
    return np.round(total / np.maximum(count, 1)[:, None]).astype(np.uint8)


def _encode(linear: NDArray[np.float64]) -> tuple[float, float, float]:
    """Linear colour to sRGB (IEC 61966-2-1)."""
    x = np.clip(linear, 0, 1)
    r, g, b = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return float(r), float(g), float(b)


def _cameras(source: Any) -> list[Camera]:
    """The file's own camera; trimesh keeps one, with a field of view in degrees (x, y)."""
    if not source.has_camera:
        return []
    camera = source.camera
    far = float(camera.z_far) if camera.z_far else None
    try:
        lens = Perspective(math.radians(float(camera.fov[1])), max(float(camera.z_near), 1e-9), far)
        return [Camera(lens, np.asarray(source.camera_transform, np.float64), camera.name or "file")]
    except Exception as error:
        logging.getLogger("ssao_gl").warning("the file's camera is unusable: %s", error)
        return []


def _up(up: str, suffix: str) -> tuple[float, float, float]:
    if up == "auto":
        return AXES["z" if suffix in Z_UP else "y"]
    if up not in AXES:
        raise SceneError(f"up axis '{up}'; must be x, y, z or auto")
    return AXES[up]


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

    def __exit__(self, *exception: object) -> None:
        np.seterr(**self._errors)
        self._logger.setLevel(self._level)
        super().__exit__(*exception)
