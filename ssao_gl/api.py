"""Whole jobs for people: one call from a scene or from arrays to a picture."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import FormatError, SettingsError, one_line
from .export.pipeline import PipelineInputs
from .export.write import write_export
from .gl.context import Context
from .io.depth_files import DepthForm, as_depth_image
from .loaders.as_scene import as_camera, as_scene
from .methods.base import Method
from .passes.denoise import Filter, Joint
from .pipeline.light import Light
from .pipeline.settings import CALM, Settings, Shading, as_filter, as_method
from .planner import Target, render_planned
from .render.picture import Picture
from .render.renderer import Renderer
from .scene.depth_image import DepthImage
from .scene.projection import Size, pixel_size
from .scene.screen_bounds import unseen
from .tiling.contact_sheet import ContactSheet
from .tiling.thumbnails import on_ground, thumbnails


def settings_of(
    method: Method | str | None = None,
    blur_with: Filter | str | None = "joint",
    shading: Shading | None = None,
    rays: float = 0.0,
    light: Light | None = None,
) -> Settings:
    """Return settings from parts or their names."""
    return Settings(method=as_method(method), blur=as_filter(blur_with), shading=shading or Shading(), rays=rays, light=light)


class Goals(TypedDict, total=False):
    """What a picture may take, or how wrong it may be; see :class:`~ssao_gl.Target`."""

    budget_ms: float | None
    max_error: float | None


def _target(goals: Goals) -> Target | None:
    """Return what is to be planned for; None where nothing is. Raises TypeError for other arguments, as Python would."""
    if unknown := set(goals) - set(Goals.__annotations__):
        raise TypeError(f"render() got an unexpected keyword argument {', '.join(map(repr, sorted(unknown)))}")
    return Target(**goals) if any(goal is not None for goal in goals.values()) else None


def _array(name: str, value: ArrayLike) -> NDArray[Any]:
    """Return an array. Raises FormatError for what cannot be one."""
    if isinstance(value, str | Path):
        raise FormatError(f"{name} is the name of a file; expected an array: read it first, by numpy.load or Pillow")
    try:
        return np.asarray(value)
    except ValueError as error:
        raise FormatError(f"{name}: expected an array; {one_line(error, 120)}") from None


def render(
    scene: Any,
    camera: Any = None,
    size: Size = (1280, 720),
    *,
    method: Method | str | None = None,
    blur: Filter | str | None = "joint",
    shading: Shading | None = None,
    light: Light | None = None,
    rays: float = 0.0,
    aovs: str | Sequence[str] = ("image", "visibility"),
    provider: str | Context = "auto",
    **goals: Unpack[Goals],
) -> Picture:
    """Draw a scene with ambient occlusion, headless.

    scene: a path, a :class:`Scene`, a ``trimesh`` mesh or scene, or a ``pyrender.Scene``. camera: a :class:`Camera`, a camera
    file, or None for the scene's own or an automatic one. size: (width, height) in pixels. aovs: any of image,
    visibility, depth, normal, bent, color, object, instance, material; or one text with names by commas. shading: light and background, ``Shading(background="white")``;
    with ``"transparent"`` the image is RGBA. light: lamps, shadows and light from all around, ``Light(shadows=True)``. rays: rays a pixel that correct what the screen cannot know, any share; needs the extra
    ``truth``. goals: ``budget_ms``, ``max_error``, by which method and options are chosen; see :func:`ssao_gl.plan`.
    """
    drawn = as_scene(scene)
    target = _target(goals)
    with Renderer(provider) as renderer:
        seen = None if camera is None else as_camera(camera, size)
        if why := unseen(drawn, seen, pixel_size(size)):
            logging.getLogger("ssao_gl").warning("%s", why)
        return render_planned(renderer, drawn, seen, size, target, settings_of(method, blur, shading, rays, light), aovs=aovs)


def sheet(
    sources: Iterable[Any],
    *,
    tile: Size = (256, 256),
    columns: int | None = None,
    background: str = CALM,
    names: bool = True,
    method: Method | str | None = None,
    provider: str | Context = "auto",
) -> Picture:
    """Draw many scenes into one picture, each seen whole, with names below.

    sources: paths, or what :func:`ssao_gl.as_scene` takes. tile: (width, height) of each, pixels. columns: None for about as
    many as rows. background: ``#rrggbb``, ``white``, ``black`` or ``transparent`` (RGBA). What cannot be drawn gets a tile
    that says why, and an entry in ``report["broken"]``: name and reason. Raises SettingsError.
    """
    things, size = list(sources), pixel_size(tile)
    if not things or not (columns is None or columns > 0):
        raise SettingsError(f"sheet of {len(things)} scenes in {columns} columns; expected some of each")
    laid = ContactSheet(count=len(things), tile=size, columns=columns, background=background, names=names)
    settings = on_ground(settings_of(method), background)
    with Renderer(provider) as renderer:
        drawn = list(thumbnails(renderer, things, size, lambda scene: settings))
    broken = [(made.name, made.fault) for made in drawn if made.fault]
    return Picture({"image": np.concatenate(list(laid.bands(drawn)))}, {"broken": broken, "scenes": len(things)})


def apply(
    color: ArrayLike | None,
    depth: ArrayLike | DepthImage | Path,
    camera: Any,
    *,
    normals: ArrayLike | None = None,
    method: Method | str | None = None,
    blur: Filter | str | None = Joint(),  # noqa: B008 - frozen
    strength: float = 1.0,
    provider: str | Context = "auto",
    **form: Unpack[DepthForm],
) -> Picture:
    """Dim a picture that you already have by the occlusion of its depth, in linear light.

    color: (h, w, 3 or 4) uint8 sRGB, or None for visibility alone; where it is larger than depth, results are upsampled
    to its size. depth: (h, w), an array, a masked array, a file or a :class:`DepthImage`: distance along the view axis in
    scene units, 0, inf and nan = background (as pyrender gives it), unless ``form`` says otherwise. camera: a
    :class:`Camera`, a camera file, or what another library calls one (pyrender, PyVista, Open3D, a matrix (3, 3)). normals: (h, w, 3) view space, rebuilt from depth without them. Row 0 is the
    top row. strength: 0 leaves the colour, 1 dims it by all of the occlusion. form: the fields of :class:`DepthImage`, as
    ``depth_kind`` ("eye", "window", "ray", "vtk"), ``depth_scale`` (0.001 reads millimetres), ``depth_background``,
    ``depth_mask``, ``depth_noise``; and ``depth_channel`` of files. What is guessed is told by ``InputWarning``. Raises
    FormatError for shapes that do not fit, for depth of another kind, and for depth without any surface.
    """
    settings = settings_of(method, blur, Shading(ambient=strength))
    image = as_depth_image(depth, **form)
    seen = as_camera(camera, image.size)
    with Renderer(provider) as renderer:
        return renderer.apply(
            image,
            seen,
            color=None if color is None else _array("color", color),
            normals=None if normals is None else _array("normals", normals),
            settings=settings,
        )


def export(
    output: str | Path,
    *,
    target: str = "webgl2",
    method: Method | str | None = None,
    blur: Filter | str | None = "joint",
    strength: float = 1.0,
    precision: str = "high",
    depth_kind: str = "window",
    normals: bool = False,
    color: bool = False,
) -> list[Path]:
    """Write the pipeline of :func:`apply` into the folder ``output``, for runtimes other than this one; return the files.

    target: ``"webgl2"`` (an ES module and its runtime), ``"gles3"`` (shaders, a C header and a program), ``"json"`` (and its
    schema). method: with a radius, in the units of your depth, which can change later. depth_kind: ``"window"`` (a depth buffer of
    any projection) or ``"eye"``. normals, color: whether they are given; without colour the result is visibility. One export
    serves every canvas size and projection. Raises SettingsError, FormatError.
    """
    settings = Settings(method=as_method(method), blur=as_filter(blur), shading=Shading(ambient=strength), precision=precision)
    return write_export(Path(output), settings, PipelineInputs(depth_kind, normals, color), target)


def widget(
    scene: Any,
    size: Size = (1280, 720),
    *,
    method: Method | str | None = None,
    blur: Filter | str | None = "joint",
    height: int = 480,
) -> Any:
    """Show a scene in a notebook: turn it, choose method and preset, wipe between before and after. Needs the extra notebook.

    scene: as for :func:`render`, of meshes or spheres. size: whose shape the view keeps. height: of the widget, CSS pixels. Its
    ``radius``, ``look``, ``show`` and ``strength`` may be assigned and observed, ``use(settings)`` shows any settings, and
    ``camera`` is the one that it shows now. Raises SettingsError, SceneError.
    """
    from .viewer.widget import scene_widget  # what pictures do without

    return scene_widget(as_scene(scene), pixel_size(size), settings_of(method, blur), height)


def occlusion(
    depth: ArrayLike | DepthImage | Path,
    camera: Any,
    *,
    normals: ArrayLike | None = None,
    method: Method | str | None = None,
    blur: Filter | str | None = "joint",
    provider: str | Context = "auto",
    **form: Unpack[DepthForm],
) -> NDArray[np.float32]:
    """Visibility (h, w) float32 in 0..1 of a depth image (h, w): 1 = open, background exactly 1. See :func:`apply`."""
    return apply(None, depth, camera, normals=normals, method=method, blur=blur, provider=provider, **form).arrays["visibility"]


def normals_from_depth(
    depth: ArrayLike | DepthImage | Path, camera: Any, *, provider: str | Context = "auto", **form: Unpack[DepthForm]
) -> NDArray[np.float32]:
    """View-space unit normals (h, w, 3) float32 of a depth image (h, w); zero on background. See :func:`apply`."""
    return apply(None, depth, camera, blur=None, provider=provider, **form).arrays["normal"]
