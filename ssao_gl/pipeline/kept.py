"""What a method wants of a scene beside its pictures: what it keeps, and voxels of it."""

from __future__ import annotations

import dataclasses

from ..errors import SettingsError
from ..methods.field import OccupancyField
from ..occupancy.grid import affordable_side
from ..scene.model import Mesh, Scene
from .settings import Settings


def check_kept(settings: Settings, scene: Scene) -> None:
    """Raise SettingsError where the method shows what the scene keeps, and it keeps nothing."""
    if settings.method.traits.any_scene or any(isinstance(thing, Mesh) and thing.baked is not None for thing in scene.drawn):
        return
    raise SettingsError(
        f"{settings.method.name}: {scene.name or 'the scene'} keeps no occlusion: no attribute _AO, no occlusion texture,"
        " no COLOR_0 in shades of grey; make such a file by ssao-gl bake, or use another method"
    )


def with_voxels(settings: Settings, scene: Scene) -> Settings:
    """Return the settings with the side of voxels settled, where the method looks into a field of them.

    They are as small as is asked for, or as memory allows: :func:`ssao_gl.occupancy.grid.affordable_side`.
    """
    method = settings.method
    if not isinstance(method, OccupancyField) or method.voxel is not None or method.radius is None:
        return settings
    side = affordable_side(scene.bounds, method.side)
    return dataclasses.replace(settings, method=dataclasses.replace(method, voxel=side))
