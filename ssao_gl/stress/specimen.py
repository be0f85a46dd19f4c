"""What is tested: methods under their presets."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import SettingsError
from ..methods.base import Deviation, Method
from ..methods.registry import check_presets, general, method, presets_of
from ..passes.denoise import filter_named
from ..pipeline.settings import Settings
from ..settings import assign, limits
from .shot import Shot

DEFAULT = "default"


@dataclass(frozen=True, slots=True)
class Specimen:
    """A method with settings, under a name."""

    name: str
    preset: str
    method: Method
    precision: str = "high"
    """As in :class:`ssao_gl.Settings`."""

    @property
    def label(self) -> str:
        return self.name if self.preset == DEFAULT else f"{self.name}:{self.preset}"

    @property
    def exceptions(self) -> Mapping[str, Deviation]:
        """What the method declares to break, by the name of the contract."""
        return self.method.exceptions

    def refuses(self, contract: str) -> bool:
        """Whether it declares to refuse a kind of camera, by an infinite bound."""
        return contract in self.exceptions and math.isinf(self.exceptions[contract].bound)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each of the method's settings."""
        return {field.name: limits(field).unit for field in dataclasses.fields(self.method)}  # type: ignore[arg-type]

    @property
    def radius_is_a_length(self) -> bool:
        """Whether the radius is in scene units, as it is for methods that know of them."""
        return self.method.traits.radius_unit == "scene units"

    def settings(self, shot: Shot) -> Settings:
        """Return settings for a shot: its filter, and as much of its radius and changes as the method has."""
        changes = {name: value for name, value in shot.changes.items() if name in self.units}
        if self.radius_is_a_length:
            changes["radius"] = shot.radius
        record: Any = dataclasses.replace(self.method, **changes)  # type: ignore[type-var]
        return Settings(
            method=record, blur=filter_named(shot.blur), normals=shot.normals_of, precision=self.precision, keep=shot.keep
        )


def specimens(methods: Sequence[str] = (), presets: Sequence[str] = (DEFAULT,), precision: str = "high") -> list[Specimen]:
    """Methods (all that draw every scene, or those named) times presets: ``default``, names, or ``all``.

    Raises SettingsError for unknown names, and for methods that show what only some scenes keep.
    """
    Settings(precision=precision)
    for name in methods:
        if not method(name).traits.any_scene:
            raise SettingsError(f"--methods {name}: shows what a scene keeps, and the scenes of the stress test keep nothing")
    shipped = {name: method(name) for name in methods or general()}
    found = [
        Specimen(name, preset, _affordable(assign(record, values)), precision)
        for name, record in shipped.items()
        for preset, values in {DEFAULT: {}, **presets_of(name)}.items()
        if "all" in presets or preset in presets
    ]
    check_presets(presets, ["all", DEFAULT, *(preset for name in shipped for preset in presets_of(name))])
    return found


def _affordable(record: Method) -> Method:
    """Return the method with fewer taps, where its own make it exhaustive: what may go wrong goes wrong in every one of them."""
    return record.traits.affordable or record
