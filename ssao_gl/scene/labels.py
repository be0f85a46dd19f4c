"""Numbers for what a scene is made of, as masks hold them, and which of it a name means."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import accumulate

from ..errors import SettingsError, near_miss
from .model import Mesh, Scene
from .spheres import Spheres
from .volume import Volume

Thing = Mesh | Spheres | Volume

Label = tuple[int, int, int]
"""Number of the thing, of its first instance, and of its material; all from 1."""


@dataclass(frozen=True, slots=True)
class SceneLabels:
    """The numbers of a scene: things in the order of :attr:`Scene.things`, their instances one after the other.

    of: a thing's ``id()`` -> its label. objects, materials: number -> name. Things without a material share one when they have
    one colour.
    """

    of: Mapping[int, Label]
    objects: Mapping[int, str]
    materials: Mapping[int, str]


def scene_labels(scene: Scene) -> SceneLabels:
    """Return the numbers of a scene; 0 is left for background."""
    looks = [_look(thing) for thing in scene.things]
    names: dict[object, str] = dict(reversed(looks))
    numbers = {key: number for number, key in enumerate(dict.fromkeys(key for key, _ in looks), 1)}
    first = accumulate((len(thing.transforms) for thing in scene.things), initial=1)
    of = {
        id(thing): (index, start, numbers[key])
        for index, (thing, start, (key, _)) in enumerate(zip(scene.things, first, looks, strict=False), 1)
    }
    objects = {index: thing.name for index, thing in enumerate(scene.things, 1)}
    return SceneLabels(of, objects, {number: names[key] for key, number in numbers.items()})


def _look(thing: Thing) -> tuple[object, str]:
    """Return what tells materials apart, and the name."""
    material = thing.material if isinstance(thing, Mesh) else None
    return (id(material), material.name) if material is not None else (thing.color, "")


def is_called(thing: Thing, names: Iterable[str]) -> bool:
    """Return whether a thing, or its material, has one of some names; ``*`` and ``?`` stand for any letters."""
    return any(fnmatchcase(own, name) for name in names for own in _names(thing))


def check_names(scene: Scene, names: Iterable[str], option: str) -> None:
    """Raise SettingsError for a name that nothing in the scene has."""
    for name in names:
        if not any(is_called(thing, [name]) for thing in scene.things):
            known = sorted({own for thing in scene.things for own in _names(thing)})
            listed = ", ".join(known[:8]) + (", ..." if len(known) > 8 else "")
            raise SettingsError(
                f"{option} {name}: nothing in {scene.name or 'the scene'} is called so; there are {listed or 'no names'}."
                + near_miss(name, known)
            )


def _names(thing: Thing) -> list[str]:
    """Return the names of a thing: its own and that of its material, where they have one."""
    material = thing.material if isinstance(thing, Mesh) else None
    return [name for name in (thing.name, material.name if material else "") if name]
