"""How a view of a scene is framed: what is drawn around the image, where in it the scene can be seen, and by which plan."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from ..graph.plan import Plan
from ..graph.regions import DrawRegion
from ..passes.temporal import Moment
from ..scene.camera import Camera
from ..scene.labels import check_names
from ..scene.lamps import LitView
from ..scene.lens import CropLens
from ..scene.model import Scene
from ..scene.projection import Size, ViewConstants
from ..scene.screen_bounds import screen_bounds
from .build import check_camera, plan_render
from .exclusion import no_casters, no_receivers
from .fill import check_fill
from .kept import check_kept, with_voxels
from .light import lit_view
from .settings import GUARD_STEP, Settings, guard_band


@dataclass(frozen=True, slots=True)
class FrameSetup:
    """A framed view.

    settings: with a radius. outer: size of all that is drawn, the guard band included, which ``view`` shows; in pixels of the
    picture, where ``view``, ``region``, ``corner`` and ``whole`` count its samples. triangles: of a
    scene that surrounds the camera, spheres counted like them, else None. region: which part of it is drawn. lit: its light.
    """

    settings: Settings
    outer: Size
    triangles: int | None
    view: ViewConstants
    region: DrawRegion
    lit: LitView
    corner: tuple[int, int]
    """Pixel of the whole picture at the lower left of what is drawn."""
    whole: Size
    """Of the picture that this is, or is a tile of."""

    def plan(self, aovs: Sequence[str], *, fine: bool = False, moment: Moment | None = None) -> Plan:
        """Return the plan that a renderer draws it by; ``fine``, ``moment``: see :func:`.build.plan_render`."""
        return plan_render(self.settings, self.outer, aovs, triangles=self.triangles, fine=fine, moment=moment)


def frame_setup(scene: Scene, camera: Camera, size: Size, settings: Settings, limit: int) -> FrameSetup:
    """Frame an image of ``size`` pixels. ``limit``: largest side of a texture.

    Raises SettingsError for a camera that the method is not defined for, and for a view that would take it too long.
    """
    settings = settings.settled(camera.ao_radius or scene.default_radius(), scene.background)
    light = settings.light and settings.light.settled(scene)
    settings = dataclasses.replace(settings, light=light)
    settings = with_voxels(settings, scene)
    many = settings.supersample
    (w, h), room = size, (limit // many - max(size)) // 2 // GUARD_STEP * GUARD_STEP
    tile = camera.lens if isinstance(camera.lens, CropLens) else CropLens(camera.lens, size, (0, 0))
    height = tile.whole[1]
    border = max(0, min(guard_band(settings.method, height), room))
    outer = w + 2 * border, h + 2 * border
    wide = dataclasses.replace(camera, lens=CropLens(camera.lens, size, (-border, -border))) if border else camera
    # Samples are the pixels of a larger frame, which shows the same.
    view = sampled(wide, outer, many).view((outer[0] * many, outer[1] * many))
    check_camera(settings, view)
    check_kept(settings, scene)
    check_names(scene, (*no_receivers(settings), *no_casters(settings)), "exclude")
    check_fill(settings, scene, wide, view)
    covered = screen_bounds(scene.bounds, camera, view)
    corner = (tile.corner[0] - border) * many, (tile.corner[1] - border) * many
    inside = (border * many, border * many, w * many, h * many) if border else None
    region = DrawRegion(inside, None if "background" in settings.keep else covered, many)
    whole = tile.whole[0] * many, tile.whole[1] * many
    lit = lit_view(light, scene, camera, size)
    return FrameSetup(settings, outer, None if covered else scene.pieces, view, region, lit, corner, whole)


def sampled(camera: Camera, size: Size, many: int) -> Camera:
    """Return the camera whose pixels are the ``many`` x ``many`` samples of each pixel of another, for an image of ``size``."""
    if many == 1:
        return camera
    part = camera.lens if isinstance(camera.lens, CropLens) else CropLens(camera.lens, size, (0, 0))
    (w, h), (x, y) = part.whole, part.corner
    return dataclasses.replace(camera, lens=CropLens(part.lens, (w * many, h * many), (x * many, y * many)))
