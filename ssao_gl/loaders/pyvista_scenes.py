"""Plotters and data sets of PyVista: what they show, with the colours that VTK would give it. No window of theirs is needed."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, one_line
from ..scene.camera import Camera
from ..scene.material import ColorTexture, Material
from ..scene.model import Mesh, Scene
from ..scene.srgb import decode
from .camera_objects import camera_of
from .finished import finished
from .mesh_building import MeshData, build_mesh
from .notes import Notes
from .trimesh_scenes import CREASE

if TYPE_CHECKING:
    import pyvista

UP = (0.0, 0.0, 1.0)
"""PyVista's views have z upwards."""
COLORS = "ssao_gl colors"
"""Array that goes with a data set through VTK's filters."""
FLAT = 0
"""VTK's interpolation of light: none over a face."""
POINT_MODES = (0, 1, 3)
"""VTK's scalar modes whose values are those of points: default, point data, point field data."""


def is_pyvista(thing: object) -> bool:
    """Whether ``thing`` is a plotter or a data set of PyVista or VTK; imports neither."""
    names = {(kind.__module__.split(".")[0], kind.__name__) for kind in type(thing).__mro__}
    known = {
        ("pyvista", "BasePlotter"),
        ("pyvista", "DataObject"),
        ("vtkmodules", "vtkDataSet"),
        ("vtkmodules", "vtkCompositeDataSet"),
    }
    return bool(names & known)


def from_pyvista(source: pyvista.Plotter | pyvista.DataSet | pyvista.MultiBlock) -> Scene:
    """Return what a ``pyvista.Plotter`` shows, or a data set, as a :class:`~ssao_gl.Scene`.

    Of a plotter: the surfaces and points of the active renderer with the colours of their scalars, textures, poses,
    background and camera. Of a data set: its surface, in colours of its own where its active scalars are RGB(A) bytes.
    Lines, labels, axes and volumes are left out, and named in ``Scene.warnings``. Raises SceneError.
    """
    import pyvista

    background: tuple[float, float, float, float] | None = None
    if not is_pyvista(source):
        raise SceneError(f"expected a Plotter or data set of PyVista, got {type(source).__name__}")
    notes = Notes()
    if hasattr(source, "renderer"):
        meshes = [mesh for name, actor in source.renderer.actors.items() for mesh in _shown(name, actor, notes)]
        cameras = [_camera(source)]
        r, g, b = (float(part) for part in source.renderer.background_color.float_rgb)
        background = r, g, b, 1.0
        name = str(getattr(source, "title", "") or "the plotter")
    else:
        meshes, cameras, name = list(_leaves_of(source, pyvista, notes)), [], type(source).__name__
    if not meshes:
        raise SceneError(f"{name} shows no surface and no points{': ' if notes.lines else ''}{'; '.join(notes.lines)}")
    made = finished(Scene(meshes, cameras, UP, name), notes)
    notes.say(name)
    return dataclasses.replace(made, background=background)


def _camera(plotter: Any) -> Camera:
    """The active camera, whose default view VTK makes when it first draws."""
    if not plotter.camera.is_set:
        plotter.camera_position = plotter.get_default_cam_pos()
        plotter.camera.is_set = False
        plotter.reset_camera()
    plotter.renderer.ResetCameraClippingRange()
    found = camera_of(plotter.camera)
    assert found is not None
    return found


def _leaves_of(source: Any, pyvista: Any, notes: Notes) -> Iterator[Mesh]:
    """Yield the meshes of a data set that no actor shows."""
    for leaf in _leaves(pyvista.wrap(source)):
        values = leaf.active_scalars
        colors = values if values is not None and values.dtype == np.uint8 and values.shape[1:] in ((3,), (4,)) else None
        at_points = colors is not None and str(leaf.active_scalars_info.association).endswith("POINT")
        yield from _meshes(leaf, colors, at_points, _Look(), notes)


def _leaves(data: Any) -> Iterator[Any]:
    if hasattr(data, "n_blocks"):
        for block in data:
            if block is not None:
                yield from _leaves(block)
    elif data is not None and data.n_points:
        yield data


@dataclasses.dataclass(frozen=True)
class _Look:
    """What an actor says of how its data look."""

    material: Material | None = None
    pose: NDArray[np.float64] = dataclasses.field(default_factory=lambda: np.eye(4))
    flat: bool = False
    points: bool = False
    name: str = ""

    @property
    def textured(self) -> bool:
        """Whether there is a picture."""
        return self.material is not None and self.material.base_color_texture is not None


def _shown(name: str, actor: Any, notes: Notes) -> Iterator[Mesh]:
    """Yield the meshes of an actor; none of what is hidden or no surface."""
    import pyvista

    mapper = getattr(actor, "mapper", None)
    if not getattr(actor, "visibility", True) or mapper is None:
        return  # labels, axes and bars lie over the picture
    if not hasattr(mapper, "MapScalars") or not hasattr(actor, "prop"):
        notes.add(f"drawn without what is no surface: {type(actor).__name__}")
        return
    if actor.prop.style == "Wireframe":
        notes.add("wireframes are left out")
        return
    mapper.Update()
    mapped = mapper.NewInstance()
    mapped.ShallowCopy(mapper)
    mapped.SetInterpolateScalarsBeforeMapping(False)  # else VTK makes texture coordinates in place of colours
    r, g, b = decode(actor.prop.color.float_rgb)
    alpha = float(actor.prop.opacity)
    look = _Look(
        Material((float(r), float(g), float(b), alpha), _texture(actor, notes), "BLEND" if alpha < 1 else "OPAQUE"),
        np.asarray(pyvista.array_from_vtkmatrix(actor.GetMatrix()), np.float64),
        actor.prop.GetInterpolation() == FLAT, actor.prop.style == "Points", one_line(name, 60),
    )  # fmt: skip
    for leaf in _leaves(pyvista.wrap(mapper.GetInputDataObject(0, 0))):
        mapped_colors = mapped.MapScalars(leaf, 1.0) if mapper.GetScalarVisibility() else None
        colors = None if mapped_colors is None else pyvista.convert_array(mapped_colors)
        points = mapper.GetScalarMode() in POINT_MODES and colors is not None and len(colors) == leaf.n_points
        yield from _meshes(leaf, colors, points, look, notes)


def _texture(actor: Any, notes: Notes) -> ColorTexture | None:
    if actor.texture is None:
        return None
    try:
        pixels = np.ascontiguousarray(actor.texture.to_array())
        return ColorTexture(pixels if pixels.ndim == 3 else np.repeat(pixels[..., None], 3, 2))
    except Exception as error:
        notes.add(f"a texture is left out ({one_line(error, 80)})")
        return None


def _meshes(data: Any, colors: Any, at_points: bool, look: _Look, notes: Notes) -> Iterator[Mesh]:
    """Yield the surface of a data set, or its points. colors: (n, 3 or 4) uint8 sRGB of its points or cells, or None."""
    shown = data.copy(deep=False)
    if colors is not None:
        (shown.point_data if at_points else shown.cell_data)[COLORS] = _rgba(np.asarray(colors))
    surface = shown if hasattr(shown, "faces") else _surface(shown)
    faces = surface.triangulate()
    triangles = np.asarray(faces.faces).reshape(-1, 4)[:, 1:]  # 3, and the three corners
    if surface.n_lines:
        notes.add("lines are left out")
    if look.points or not len(triangles):
        if look.points or surface.n_verts:
            yield _points(surface, look)
        return
    # Cells have colours of their own: their corners are not shared.
    corners = triangles.ravel() if COLORS in faces.cell_data else np.arange(faces.n_points)
    made = MeshData(np.asarray(faces.points)[corners], triangles, material=look.material)
    if COLORS in faces.cell_data:
        made.faces = np.arange(triangles.size).reshape(-1, 3)
        made.colors = np.repeat(np.asarray(faces.cell_data[COLORS])[-len(triangles) :], 3, axis=0)
    elif colors is not None:
        made.colors = np.asarray(faces.point_data[COLORS])
    if colors is not None:
        alpha = 1.0 if look.material is None else look.material.base_color[3]
        made.material = Material((1.0, 1.0, 1.0, alpha), None, "BLEND" if alpha < 1 else "OPAQUE")
    elif look.textured and faces.active_texture_coordinates is not None:
        u, v = np.asarray(faces.active_texture_coordinates, np.float64).T[:2]
        made.uv = np.column_stack([u, 1 - v])
    if not look.flat and "Normals" in faces.point_data:
        made.normals = np.asarray(faces.point_data["Normals"])[corners]
    yield build_mesh(made, look.pose[None], look.name, 0.0 if look.flat else CREASE)


def _surface(data: Any) -> Any:
    """Return the outside of cells, by VTK's own filter: PyVista's methods for it change from version to version."""
    import pyvista
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

    found = vtkGeometryFilter()
    found.SetInputData(data)
    found.Update()
    return pyvista.wrap(found.GetOutput())


def _points(surface: Any, look: _Look) -> Mesh:
    world = np.asarray(surface.points, np.float64) @ look.pose[:3, :3].T + look.pose[:3, 3]
    if COLORS in surface.point_data:
        colors: Any = np.asarray(surface.point_data[COLORS])
    else:
        colors = None if look.material is None else np.tile([*look.material.color, 1.0], (len(world), 1))
    return Mesh.from_points(world, colors, name=look.name)


def _rgba(colors: NDArray[np.uint8]) -> NDArray[np.uint8]:
    alpha = np.full((len(colors), 1), 255, np.uint8)
    return colors if colors.shape[1] == 4 else np.concatenate([colors, alpha], 1)
