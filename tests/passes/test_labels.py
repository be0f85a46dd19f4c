"""Masks: whole numbers of things, instances and materials, of meshes, spheres and volumes, and nothing when nobody asks."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.pipeline.build import plan_render
from ssao_gl.render.picture import mask_png
from ssao_gl.scene.material import Material
from ssao_gl.scene.model import Scene

from ..shapes import camera, quad

SIZE = (64, 48)
MASKS = "object,instance,material,depth"
RED = Material((1.0, 0.0, 0.0, 1.0), name="red")


def at(*places: tuple[float, float, float]) -> np.ndarray:
    made = np.repeat(np.eye(4)[None], len(places), 0)
    made[:, :3, 3] = places
    return made


def test_every_kind_of_thing_has_its_numbers(any_renderer: ao.Renderer) -> None:
    """A copy keeps its number, whichever others are seen; things of one material share one, and so do those of one colour."""
    sheet = dataclasses.replace(quad((0, 0, 0), (0.4, 0, 0), (0, 0.4, 0)), material=RED, name="sheet")
    ball = ao.Spheres(np.zeros((1, 3), np.float32), np.full(1, 0.4, np.float32), name="ball")
    scene = Scene(
        [
            dataclasses.replace(sheet, transforms=at((-1, 0.6, -4), (0, 0.6, -4))),
            dataclasses.replace(sheet, transforms=at((1, 0.6, -4)), name="other"),
            dataclasses.replace(quad((0, 0, -6), (9, 0, 0), (0, 9, 0)), color=(0, 0, 1)),
        ],
        spheres=[dataclasses.replace(ball, color=(0, 0, 1), transforms=at((50, 0, -4), (-1, -0.6, -4), (1, -0.6, -4)))],
    )
    picture = any_renderer.render(scene, camera(), SIZE, aovs=MASKS, checked=True)
    places = [(19, 16), (32, 16), (44, 16), (19, 31), (44, 31), (32, 24)]
    numbers = [tuple(int(getattr(picture, name)[y, x]) for name in ("object", "instance", "material")) for x, y in places]
    assert numbers == [(1, 1, 1), (1, 2, 1), (2, 3, 1), (4, 6, 2), (4, 7, 2), (3, 4, 2)]
    assert all(picture.arrays[name].dtype == np.uint32 for name in ("object", "instance", "material"))
    assert picture.report["labels"]["object"] == {1: "sheet", 2: "other", 3: "", 4: "ball"}
    assert picture.report["labels"]["material"] == {1: "red", 2: ""}


@pytest.mark.parametrize("many", [1, 2])
def test_background_is_nought_and_png_holds_the_numbers(
    any_renderer: ao.Renderer, embedded: Scene, many: int, tmp_path: Path
) -> None:
    picture = any_renderer.render(embedded, None, SIZE, ao.Settings(supersample=many), aovs=MASKS)
    for name in ("object", "instance", "material"):
        assert ((picture.arrays[name] == 0) == (picture.depth == 0)).all()
    picture.save(tmp_path / "i.png", aov="instance")
    with Image.open(tmp_path / "i.png") as saved:
        assert (np.asarray(saved) == picture.instance).all() and np.asarray(saved).dtype == np.uint16


def test_numbers_beyond_sixteen_bits_are_refused() -> None:
    with pytest.raises(ao.FormatError, match=r"write \.npy"):
        mask_png("instance", np.array([[65536]], np.uint32))


def test_no_mask_costs_nothing() -> None:
    plan = plan_render(ao.Settings(method=ao.Bitmask(radius=1.0)), SIZE, ("image", "visibility"))
    assert "labels" not in plan.describe()
