"""Contract tests of AO methods: what every method promises, for the tests of plug-ins and for ssao_gl's own.

    from ssao_gl.testing import check_method
    check_method("glow")  # AssertionError, with a line for every promise that is broken

or, a test a promise, under pytest::

    @pytest.mark.parametrize("contract", CONTRACTS)
    def test_glow(contract):
        with ssao_gl.Renderer() as renderer:
            CONTRACTS[contract](renderer, "glow")

A method whose published definition breaks a promise declares it in ``exceptions``, with a bound that holds instead.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import SettingsError
from .methods.base import Method
from .methods.registry import method, registry
from .passes.denoise import Joint
from .pipeline.settings import Settings
from .render.renderer import Renderer
from .scene.camera import Camera
from .scene.model import Scene
from .scene.projection import Size
from .scene.sample_scene import default_scene
from .stress.shapes import corner, lens, moved, plane, scaled

STEP = 1 / 255 + 1e-6
"""Of visibility: what is kept of it has 8 bits."""
EDGES = 0.002
"""Share of the pixels that may differ where an edge rounds to the next pixel."""
_SIZE = (96, 72)
Visibility = NDArray[np.float32]


def check_method(name: str, provider: str = "auto") -> None:
    """Check every promise of the registered method ``name``. Raises AssertionError, one line for each that is broken.

    Raises SettingsError for a name that is not registered, ContextError where there is no OpenGL.
    """
    method(name)
    broken = []
    with Renderer(provider) as renderer:
        for contract, check in CONTRACTS.items():
            try:
                check(renderer, name)
            except AssertionError as error:
                broken.append(f"{contract}: {error}")
    if broken:
        raise AssertionError(f"the AO method {name} breaks {len(broken)} of {len(CONTRACTS)} contracts:\n" + "\n".join(broken))


def with_radius(record: Method, radius: float) -> Any:
    """Return the method with a radius in scene units; one whose radius is something else keeps its own."""
    if record.traits.radius_unit != "scene units":
        return record
    return dataclasses.replace(record, radius=radius)  # type: ignore[type-var]


def spread(record: Method) -> int:
    """Return how many times as many pixels change with each that is drawn: a smaller target shows in its neighbours too."""
    return 4 if record.traits.scale > 1 else 1


def a_plane_is_open(renderer: Renderer, name: str) -> None:
    """Nothing occludes a plane, however it is tilted (``exceptions["plane"]``: 1 - the darkest pixel)."""
    for tilt in (0.0, 0.6, -1.2, 1.4):
        for blur in (None, Joint()):
            seen = _draw(renderer, name, plane(tilt), lens(), blur=blur)
            what = f"tilted by {tilt} radians, {'filtered' if blur else 'raw'}, 1 - the darkest pixel"
            _at_most(what, 1 - seen.min(), _bound(name, "plane", STEP))


def a_corner_is_darker_than_its_walls(renderer: Renderer, name: str) -> None:
    """Where two walls meet, visibility is less by 0.1 at least than far from there."""
    seen = _draw(renderer, name, corner(), lens(), blur=Joint()).mean(0)
    _at_most("0.1 - (walls - corner)", 0.1 - (np.r_[seen[:12], seen[-12:]].mean() - seen[44:52].mean()), 0)


def no_radius_no_occlusion(renderer: Renderer, name: str) -> None:
    """With next to no radius all is open (``exceptions["radius"]``)."""
    settings = Settings(method=dataclasses.replace(method(name), radius=1e-6), blur=None)
    seen = renderer.render(corner(), lens(), _SIZE, settings, aovs=("visibility",)).visibility
    _at_most("1 - the darkest pixel", 1 - seen.min(), _bound(name, "radius", STEP))


def the_same_input_gives_the_same_bytes(renderer: Renderer, name: str) -> None:
    """Two draws of the same are the same."""
    scene = default_scene()
    first, second = (_draw(renderer, name, scene, scene.cameras[0], blur=Joint()) for _ in range(2))
    _at_most("pixels that differ", (first != second).sum(), 0)


def units_do_not_matter(renderer: Renderer, name: str) -> None:
    """A scene in millimetres looks as one in kilometres (``exceptions["scale"]``: share of the pixels that differ)."""
    scene = default_scene()

    def shot(s: float) -> Visibility:
        camera = scene.cameras[0]
        pose = camera.pose.copy()
        pose[:3, 3] *= s
        made = Camera.perspective(camera.lens.yfov, camera.lens.znear * s, camera.lens.zfar * s, pose)  # type: ignore[attr-defined]
        return _draw(renderer, name, scaled(scene, s), made, 0.7 * s)

    first = shot(1.0)
    for factor in (1e-6, 1e-3, 1e3, 1e6):
        _at_most(f"units of {factor}, pixels that differ", _share(first, shot(factor)), _bound(name, "scale", _edges(name)))


def the_place_in_the_world_does_not_matter(renderer: Renderer, name: str) -> None:
    """A scene far from the origin looks as one near it (``exceptions["translation"]``: share of the pixels that differ)."""
    shift = np.eye(4)
    shift[:3, 3] = [1e7, -3e6, 2e7]
    here, far = default_scene(), moved(default_scene(), shift)
    seen = [_draw(renderer, name, scene, scene.cameras[0]) for scene in (here, far)]
    _at_most("pixels that differ", _share(*seen), _bound(name, "translation", _edges(name)))


def the_far_plane_does_not_matter(renderer: Renderer, name: str) -> None:
    """What lies behind the scene changes nothing (``exceptions["far plane"]``: mean difference)."""
    near, far = (_draw(renderer, name, corner(), lens(zfar)) for zfar in (20.0, 200.0))
    _at_most("mean difference", np.abs(near - far).mean(), _bound(name, "far plane", 1e-4))


def a_parallel_projection_is_like_any_other(renderer: Renderer, name: str) -> None:
    """A plane is open and a corner dark there too, or the method refuses (``exceptions["orthographic"]``: infinity)."""
    parallel = Camera.orthographic(4.0, 0.0, 40.0)
    if math.isinf(_bound(name, "orthographic", 0)):
        try:
            _draw(renderer, name, corner(), parallel)
        except SettingsError as error:
            _at_most("refusals that do not name the method", name not in str(error), 0)
            return
        raise AssertionError("it declares to refuse a parallel projection, and draws")
    flat = _draw(renderer, name, plane(0.7), parallel)
    _at_most("a plane, 1 - the darkest pixel", 1 - flat.min(), _bound(name, "plane", STEP))
    seen = _draw(renderer, name, corner(), parallel, blur=Joint()).mean(0)
    _at_most("0.1 - (walls - corner)", 0.1 - (seen[:8].mean() - seen[44:52].mean()), 0)


def an_off_centre_lens_shows_a_part_of_the_whole(renderer: Renderer, name: str) -> None:
    """The left half of a wide image equals an image by a lens shifted to the left (``exceptions["border"]``: share that differs)."""
    scene = default_scene()
    wide = scene.cameras[0]
    left = wide.lens.matrix((192, 72)).copy()
    left[0] = 2 * left[0] + left[3]  # x in -1..0 stretched to -1..1
    whole = _draw(renderer, name, scene, wide, size=(192, 72))[:, :96]
    part = _draw(renderer, name, scene, Camera.from_matrix(left, wide.pose))
    inner = slice(0, 96 - 24)  # away from the new border, beyond which taps are lost
    differ = float((np.abs(whole - part)[:, inner] > STEP).mean())
    _at_most("pixels that differ", differ, _bound(name, "border", 0.01))


def any_size_will_do(renderer: Renderer, name: str) -> None:
    """Pictures of a pixel, of a row, and of no multiple of anything."""
    scene = default_scene()
    for size in ((1, 1), (1, 40), (40, 1), (2, 2), (33, 17)):
        seen = _draw(renderer, name, scene, scene.cameras[0], blur=Joint(), size=size)
        if seen.shape != size[::-1]:
            raise AssertionError(f"size {size[0]}x{size[1]} gives visibility of shape {seen.shape}")


CONTRACTS: Mapping[str, Callable[[Renderer, str], None]] = {
    check.__name__: check
    for check in (
        *(a_plane_is_open, a_corner_is_darker_than_its_walls, no_radius_no_occlusion, the_same_input_gives_the_same_bytes),
        *(units_do_not_matter, the_place_in_the_world_does_not_matter, the_far_plane_does_not_matter),
        *(a_parallel_projection_is_like_any_other, an_off_centre_lens_shows_a_part_of_the_whole, any_size_will_do),
    )
}
"""Every promise by its name. Each takes a renderer and the name of a method, and raises AssertionError where it is broken."""


def _draw(
    renderer: Renderer, name: str, scene: Scene, camera: Camera, radius: float = 0.8, blur: Any = None, size: Size = _SIZE
) -> Visibility:
    """Return visibility (h, w), which must be finite, in 0..1, and 1 on background."""
    settings = Settings(method=with_radius(method(name), radius), blur=blur)
    picture = renderer.render(scene, camera, size, settings, aovs=("visibility", "depth"), checked=True)
    seen = picture.visibility
    _at_most("pixels out of 0..1", (~((seen >= 0) & (seen <= 1))).sum(), 0)
    _at_most("pixels of background that are not open", (seen[picture.depth == 0] != 1).sum(), 0)
    return seen


def _bound(name: str, contract: str, default: float) -> float:
    declared = registry()[name].exceptions.get(contract)
    return declared.bound if declared else default


def _edges(name: str) -> float:
    return EDGES * spread(method(name))


def _share(one: Visibility, other: Visibility) -> float:
    return float((np.abs(one - other) > STEP).mean())


def _at_most(what: str, measured: float, bound: float) -> None:
    if not measured <= bound:
        raise AssertionError(f"{what}: {measured:.4g}, at most {bound:.4g}")
