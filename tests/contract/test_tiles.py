"""Pictures drawn in tiles: the same as drawn whole."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.methods.registry import general
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene
from ssao_gl.testing import spread, with_radius
from ssao_gl.tiling.layout import Layout, layout, unguarded

from ..shapes import camera, plane

SIZE = (640, 360)
STEP = 1 / 255 + 1e-6
ALL = ("image", "visibility", "depth", "normal", "color")
RIM = 4
"""Pixels along the border of a picture that a filter sees beyond."""
VIEWS = ("perspective", "off-centre", "orthographic", "plane", "plane off-centre", "plane orthographic")
FAST = [name for name in general() if name != "reference"]
"""All methods but the exhaustive one, which would take minutes."""
CASES = [(view, name) for view in VIEWS for name in FAST if name != "lecture" or "orthographic" not in view]
"""The lecture's method refuses parallel projections."""


def off_centre(cam: Camera, size: tuple[int, int]) -> Camera:
    matrix = cam.lens.matrix(size).copy()
    matrix[0] += 0.4 * matrix[3]
    matrix[1] -= 0.25 * matrix[3]
    return Camera.from_matrix(matrix, cam.pose)


def views(embedded: Scene) -> dict[str, tuple[Scene, Camera]]:
    cam = embedded.cameras[0]
    tilted = plane(1.1)
    return {
        "perspective": (embedded, cam),
        "off-centre": (embedded, off_centre(cam, SIZE)),
        "orthographic": (embedded, Camera.orthographic(5.0, 0.0, 30.0, cam.pose)),
        "plane": (tilted, camera()),
        "plane off-centre": (tilted, off_centre(camera(), SIZE)),
        "plane orthographic": (tilted, Camera.orthographic(8.0, 0.1, 40.0)),
    }


def settings(name: str, blur: Any = None, **changes: Any) -> ao.Settings:
    method: Any = with_radius(ao.method(name), 0.25) if name != "lecture" else ao.Lecture(radius=0.05)
    return ao.Settings(method=method, blur=blur, **changes)


def stitched(
    renderer: ao.Renderer, scene: Scene, cam: Camera, made: ao.Settings, tile: int, aovs: tuple[str, ...], bits: int = 16
) -> dict[str, np.ndarray]:
    """A picture of ``SIZE`` in tiles."""
    cut = layout(scene, cam, SIZE, made, aovs, tile=tile)
    assert cut is not None and cut.columns > 1 and cut.rows > 1 and cut.halo == cut.wanted
    return put_together(renderer, scene, cam, made, cut, aovs, bits)


def put_together(
    renderer: ao.Renderer, scene: Scene, cam: Camera, made: ao.Settings, cut: Layout, aovs: tuple[str, ...], bits: int = 16
) -> dict[str, np.ndarray]:
    """Tiles put together in memory."""
    rows: list[list[dict[str, np.ndarray]]] = []
    for index, piece in enumerate(cut.tiles()):
        if index % cut.columns == 0:
            rows.append([])
        picture = renderer.render(
            scene, piece.camera(cam, SIZE), piece.outer.size, unguarded(made), aovs=aovs, visibility_bits=bits, checked=True
        )
        rows[-1].append({name: piece.crop(array) for name, array in picture.arrays.items()})
    return {name: np.concatenate([np.concatenate([part[name] for part in row], 1) for row in rows]) for name in aovs}


@pytest.mark.parametrize("blur", [None, ao.Joint()], ids=["raw", "joint"])
@pytest.mark.parametrize(("view", "name"), CASES)
def test_tiles_are_the_whole(any_renderer: ao.Renderer, embedded: Scene, view: str, name: str, blur: Any) -> None:
    """2x2 tiles, the upper and the right ones smaller: planes to one step, at edges a few taps may move by a texel.

    Vertices are rounded to fractions of a pixel after the projection, which differs, so a tap that hits the border of
    two texels may take the other one. A seam along the tiles would be a hundred times as many pixels. At the rim of the
    picture the filter of a whole one does not see what is drawn around it, that of a tile does.
    """
    scene, cam = views(embedded)[view]
    made = settings(name, blur)
    whole = any_renderer.render(scene, cam, SIZE, made, aovs=("visibility",), visibility_bits=8).visibility
    off = np.abs(stitched(any_renderer, scene, cam, made, 336, ("visibility",), 8)["visibility"] - whole)
    if getattr(made.method, "guard", 0):
        off = off[RIM:-RIM, RIM:-RIM]
    if scene is not embedded:
        assert off.max() <= STEP
    assert (off > STEP).mean() <= 1e-4 * spread(made.method) and (off > 0).mean() <= 1e-3


@pytest.mark.parametrize("share", [0.25, 1.3])
@pytest.mark.parametrize("view", ["perspective", "off-centre", "orthographic"])
def test_rays_are_those_of_the_whole(any_renderer: ao.Renderer, embedded: Scene, view: str, share: float) -> None:
    """Where they start is rounded otherwise, so a ray in a thousand may meet another thing; the filter leaves little of it."""
    pytest.importorskip("embreex")
    scene, cam = views(embedded)[view]
    made = settings("bitmask", ao.Joint(), rays=share)
    whole = any_renderer.render(scene, cam, SIZE, made, aovs=("visibility",), visibility_bits=8).visibility
    off = np.abs(stitched(any_renderer, scene, cam, made, 336, ("visibility",), 8)["visibility"] - whole)[RIM:-RIM, RIM:-RIM]
    assert (off > STEP).mean() <= 1e-3 and (off > 0).mean() <= 1e-2 and off.max() <= 0.1
    bare = np.abs(
        any_renderer.render(scene, cam, SIZE, settings("bitmask", ao.Joint()), aovs=("visibility",)).visibility - whole
    )
    assert (bare > STEP).mean() > 0.1, "rays change it"


@pytest.mark.parametrize("blur", [ao.LectureBlur(), ao.Separable(radius=8)], ids=["lecture", "separable"])
@pytest.mark.parametrize("tile", [64, 80, 100, 160, 352])
def test_tiles_of_any_side_under_any_filter(any_renderer: ao.Renderer, embedded: Scene, tile: int, blur: Any) -> None:
    made, cam = settings("alchemy", blur), embedded.cameras[0]
    whole = any_renderer.render(embedded, cam, SIZE, made, aovs=("visibility",), visibility_bits=8).visibility
    off = np.abs(stitched(any_renderer, embedded, cam, made, tile, ("visibility",), 8)["visibility"] - whole)
    assert (off > STEP).mean() <= 1e-4 and (off > 0).mean() <= 1e-3


def test_without_the_halo_there_are_seams(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """The halo is needed: what the tests above would find without it."""
    made, cam = settings("alchemy", ao.Joint()), embedded.cameras[0]
    whole = any_renderer.render(embedded, cam, SIZE, made, aovs=("visibility",)).visibility
    cut = layout(embedded, cam, SIZE, made, ("visibility",), tile=160)
    assert cut is not None
    bare = dataclasses.replace(cut, halo=0)
    off = np.abs(put_together(any_renderer, embedded, cam, made, bare, ("visibility",))["visibility"] - whole)
    assert (off > STEP).mean() > 5e-3


def test_each_tile_is_drawn_once_in_one_piece_of_memory(any_renderer: ao.Renderer, embedded: Scene) -> None:
    """No more pixels are drawn than tiles with their halos have."""
    made, cam = settings("alchemy"), embedded.cameras[0]
    cut = layout(embedded, cam, SIZE, made, ("visibility",), tile=160)
    assert cut is not None
    drawn = sum(tile.outer.w * tile.outer.h for tile in cut.tiles())
    assert drawn <= cut.columns * cut.rows * (160 + 2 * cut.halo) ** 2
    assert max(cut.outer) <= 160 + 2 * cut.halo


# Last, because a context of OSMesa takes those of EGL along when it is released

LIMITS = {"image": 1, "visibility": STEP, "depth": 1e-5, "normal": 1e-3, "color": 0}
"""What an array may be off by, depth relative to itself."""


def test_every_array_on_every_driver(renderer: ao.Renderer, embedded: Scene) -> None:
    """Depth is the same to the last bits, the rest but for pixels on the edges of triangles."""
    made, cam = settings("alchemy", ao.Joint()), embedded.cameras[0]
    whole = renderer.render(embedded, cam, SIZE, made, aovs=ALL).arrays
    drawn = stitched(renderer, embedded, cam, made, 160, ALL)
    for name, limit in LIMITS.items():
        a, b = (np.asarray(arrays[name], np.float64) for arrays in (drawn, whole))
        off = np.abs(a - b) / (np.maximum(whole["depth"], 1e-9) if name == "depth" else 1)
        assert (off > limit).mean() < 5e-4, name
