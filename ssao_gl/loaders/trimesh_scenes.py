"""Meshes and scenes of trimesh, and the files that it reads."""

from __future__ import annotations

import dataclasses
import gc
import logging
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, one_line
from ..io.atomic import why_unreadable
from ..scene.camera import Camera, Perspective
from ..scene.model import Mesh, Scene
from ..scene.vertex_normals import crease_normals, weld
from . import textures

if TYPE_CHECKING:
    import trimesh

LOG = logging.getLogger("ssao_gl")

Z_UP = frozenset({"stl", "3mf", "ply", "off"})
"""Formats in which z is usually up; in all others y is. It only turns automatic views."""

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
DEFAULT_COLOR = (0.8, 0.8, 0.8)
CREASE = math.radians(40)

SPAN = (1e-30, 1e30)
"""Sizes of a scene that 32-bit arithmetic can take."""
FAR = 16
"""Sizes of a mesh that its middle may lie off the origin before its vertices are stored about the middle."""
LARGE = 10**5
"""Triangles from which memory is given back at once."""
MAX_TRIANGLES = 10**9
"""More, by instances of instances, would keep a software renderer busy for hours."""


def load_mesh_file(path: Path | str, *, crease: float = CREASE, up: str = "auto") -> Scene:
    """Read a mesh or scene file (GLB, glTF, OBJ, PLY, STL, OFF ...). Nothing outside its folder is read, nothing is fetched.

    crease: faces of meshes without normals that meet at more than this angle (radians) keep a sharp edge; 0 shades flat.
    up: ``"x"``, ``"y"``, ``"z"``, or ``"auto"`` by format. Raises SceneError, in one line, for anything unreadable.
    """
    path = Path(path)
    if reason := why_unreadable(path):
        raise SceneError(f"{path}: {reason}; expected a scene file")
    try:
        with _quiet():
            scene = _read(path, crease, up)
    except SceneError as error:
        raise SceneError(f"{path}: {one_line(error, 500)}") from error
    except (KeyboardInterrupt, SystemExit):
        raise
    except MemoryError as error:
        raise SceneError(f"{path}: needs more memory than there is") from error
    except BaseException as error:  # the readers raise whatever a broken file leads them into
        brief = one_line(error, 200) or "its data contradict each other"
        raise SceneError(
            f"{path}: not a readable mesh file ({type(error).__name__}: {brief}); is it truncated or broken?"
        ) from error
    if scene.triangles > LARGE:
        gc.collect()  # meshes of trimesh refer to themselves, and would stay beside what is uploaded now
    return scene


def _read(path: Path, crease: float, up: str) -> Scene:
    from . import mesh_files

    loaded = mesh_files.read(path)
    soup = loaded.kind not in mesh_files.GLTF
    scene = from_trimesh(loaded.scene, crease=crease, up=_up(up, loaded.kind), name=path.name, weld_vertices=soup)
    if loaded.missing:
        names = ", ".join(repr(name) for name in dict.fromkeys(loaded.missing))
        LOG.warning("%s: drawn without %s, which is not in its folder", path, one_line(names))
    return dataclasses.replace(scene, cameras=loaded.cameras or scene.cameras)


def from_trimesh(
    source: trimesh.Trimesh | trimesh.Scene,
    *,
    crease: float = CREASE,
    up: tuple[float, float, float] = AXES["y"],
    name: str = "",
    weld_vertices: bool = False,
) -> Scene:
    """A :class:`~ssao_gl.Scene` from a ``trimesh.Trimesh`` or ``trimesh.Scene``; instances share one geometry.

    weld_vertices: vertices at the same place become one where normals must be made, so that they are smooth.
    """
    import trimesh

    if isinstance(source, trimesh.Trimesh):
        source = trimesh.Scene(source)
    if not isinstance(source, trimesh.Scene):
        raise SceneError(f"expected a trimesh.Trimesh or trimesh.Scene, got {type(source).__name__}")
    places: dict[str, list[NDArray[np.float64]]] = {}
    for node in source.graph.nodes_geometry:
        matrix, geometry = source.graph.get(node)
        places.setdefault(str(geometry), []).append(np.asarray(matrix, np.float64))
    meshes = {}
    for key in places:
        geometry = source.geometry.get(key)
        if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces):
            meshes[key] = geometry
    sampled = textures.sample(meshes)
    draws = [_draw(mesh, np.stack(places[key]), key, crease, weld_vertices, sampled.get(key)) for key, mesh in meshes.items()]
    if not draws:
        kinds = sorted({type(geometry).__name__ for geometry in source.geometry.values()} - {"Trimesh"})
        raise SceneError("holds no triangles" + (f", only {', '.join(kinds)}" if kinds else ""))
    scene = Scene(draws, cameras=_cameras(source), up=up, name=name)
    _check_span("the scene", scene.bounds)
    if scene.triangles > MAX_TRIANGLES:
        raise SceneError(f"draws {scene.triangles:,} triangles, instances counted each; at most {MAX_TRIANGLES:,} are drawn")
    return scene


def _draw(
    mesh: trimesh.Trimesh,
    transforms: NDArray[np.float64],
    name: str,
    crease: float,
    soup: bool,
    sampled: NDArray[np.uint8] | None,
) -> Mesh:
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    low, high = int(faces.min()), int(faces.max())
    if low < 0 or high >= len(vertices):
        raise SceneError(
            f"mesh '{name}': a triangle names vertex {low if low < 0 else high}; there are 0 to {len(vertices) - 1}"
        )
    positions, transforms = _centered(_finite(vertices, faces, name), transforms, name)
    triangles = faces.astype(np.uint32)
    color, vertex_colors = _colors(mesh, sampled)
    normals = None
    if "vertex_normals" in mesh._cache:  # read from the file, not computed by trimesh
        normals = np.asarray(mesh.vertex_normals, np.float32)
    elif crease > 0:
        if soup:
            positions, triangles, source = weld(positions, triangles, vertex_colors)
            vertex_colors = _picked(vertex_colors, source)
        positions, triangles, normals, source = crease_normals(positions, triangles, crease)
        vertex_colors = _picked(vertex_colors, source)
    visual: Any = mesh.visual
    if visual.kind == "face":
        vertex_colors = _face_means(np.asarray(visual.face_colors), triangles, len(positions))
    return Mesh(positions, triangles, normals, color, vertex_colors, transforms, name)


def _picked(values: NDArray[np.uint8] | None, source: NDArray[np.uint32] | None) -> NDArray[np.uint8] | None:
    return values if values is None or source is None else values[source]


def _finite(vertices: NDArray[np.float64], faces: NDArray[np.int64], name: str) -> NDArray[np.float64]:
    """Vertices without NaN and infinity. Scanners use them for points that were not seen, which no triangle may name."""
    if math.isfinite(vertices.min()) and math.isfinite(vertices.max()):
        return vertices
    broken = ~np.isfinite(vertices.sum(1))
    named = int(broken[faces].any(1).sum())
    if named:
        raise SceneError(
            f"mesh '{name}': {named} of {len(faces)} triangles have vertices that are not finite numbers (NaN or infinity)"
        )
    return np.where(broken[:, None], vertices[faces[0, 0]], vertices)


def _centered(
    vertices: NDArray[np.float64], transforms: NDArray[np.float64], name: str
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Vertices as 32-bit floats, about their middle where they lie far from the origin: there floats are too coarse."""
    box = np.stack([vertices.min(0), vertices.max(0)])
    _check_span(f"mesh '{name}'", box)
    middle = box.mean(0)
    if np.abs(middle).max() <= FAR * (box[1] - box[0]).max():
        return vertices.astype(np.float32), transforms
    positions = np.empty(vertices.shape, np.float32)
    np.subtract(vertices, middle, out=positions, casting="same_kind")
    shifted = transforms.copy()
    shifted[:, :3, 3] += transforms[:, :3, :3] @ middle
    return positions, shifted


def _check_span(what: str, box: NDArray[np.float64]) -> None:
    """32-bit floats square lengths on the way; outside this range they would overflow or vanish."""
    span = float((box[1] - box[0]).max())
    if span and not SPAN[0] <= span <= SPAN[1]:
        raise SceneError(f"{what} is {span:g} units large; it must be {SPAN[0]:g} to {SPAN[1]:g}: scale it")


def _colors(mesh: Any, sampled: NDArray[np.uint8] | None) -> tuple[tuple[float, float, float], NDArray[np.uint8] | None]:
    """(base colour, vertex colours) in sRGB. ``sampled``: its texture's at the vertices. Faces' own colours come later."""
    visual, white = mesh.visual, (1.0, 1.0, 1.0)
    if visual is None or not visual.defined:
        return DEFAULT_COLOR, None
    if visual.kind == "vertex":
        return white, np.asarray(visual.vertex_colors, np.uint8)
    if visual.kind == "face":
        return white, None
    material, color = getattr(visual, "material", None), DEFAULT_COLOR
    factor = getattr(material, "baseColorFactor", None)
    if factor is not None:  # glTF's factors are linear
        color = _encode(np.asarray(factor, np.float64)[:3] / 255)
    elif hasattr(material, "baseColorFactor"):
        color = white
    elif (main := getattr(material, "main_color", None)) is not None:
        r, g, b = (float(c) / 255 for c in main[:3])
        color = (r, g, b)
    if sampled is not None:
        return (color if factor is not None else white), sampled
    colors = visual.vertex_attributes.get("color")
    if colors is not None and np.shape(colors) in ((len(mesh.vertices), 3), (len(mesh.vertices), 4)):
        from trimesh.visual.color import to_rgba

        return color, np.asarray(to_rgba(colors), np.uint8)
    return color, None


def _face_means(colors: NDArray[np.uint8], triangles: NDArray[np.uint32], count: int) -> NDArray[np.uint8]:
    """Vertex colours from those of the faces around: exact at sharp edges, whose faces share no vertex."""
    total = np.stack([sum(np.bincount(triangles[:, k], c, count) for k in range(3)) for c in colors.T], 1)
    faces = np.bincount(triangles.ravel(), minlength=count)
    return np.round(total / np.maximum(faces, 1)[:, None]).astype(np.uint8)


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
        LOG.warning("the file's camera is unusable: %s", one_line(error))
        return []


def _up(up: str, kind: str) -> tuple[float, float, float]:
    if up == "auto":
        return AXES["z" if kind in Z_UP else "y"]
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

    def __exit__(self, *exception: Any) -> None:
        np.seterr(**self._errors)
        self._logger.setLevel(self._level)
        super().__exit__(*exception)
