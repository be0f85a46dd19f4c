"""What a method may want that only some scenes keep."""

from __future__ import annotations

from ..errors import SettingsError
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
