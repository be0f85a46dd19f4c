"""What is asked for of a batch: its scenes and cameras, what is drawn of them, and how it is called."""

from __future__ import annotations

import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import SettingsError, near_miss
from ..pipeline.outputs import aov_names
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.projection import Size, pixel_size
from .views import Around

FORMATS = ("auto", "npy", "png", "exr")
PICTURES = ("image", "color")
"""AOVs that are 8-bit colours: PNG files, unless another format is asked for."""
NAMES = "{scene}/{camera}/{aov}"
FIELDS = ("scene", "camera", "aov", "index", "number")


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a row of a manifest may say, and what holds for all rows that do not.

    cameras: see :func:`.views.views_of`. size: (width, height), pixels. settings: their radius may be open. share: the radius
    as a share of the scene's size, None for the settings' own. aovs: see :class:`ssao_gl.Picture`. formats: files of each AOV, of
    npy, png and exr; auto: PNG for colours, NPY for all else. names: of files, without suffix, by the fields scene, camera, aov,
    index (of the view in its scene) and number (of all views). Raises SettingsError.
    """

    cameras: str | Camera | None = None
    size: Size = (1280, 720)
    settings: Settings = field(default_factory=Settings)
    share: float | None = None
    aovs: str | Sequence[str] = ("image", "visibility")
    formats: tuple[str, ...] = ("auto",)
    names: str = NAMES
    around: Around = field(default_factory=Around)
    provider: str = "auto"

    def __post_init__(self) -> None:
        object.__setattr__(self, "aovs", aov_names(self.aovs))
        object.__setattr__(self, "size", pixel_size(self.size))
        for name in self.formats:
            if name not in FORMATS:
                raise SettingsError(
                    f"format '{name}': there is no such format; there are {', '.join(FORMATS)}.{near_miss(name, FORMATS)}"
                )
        _check_names(self.names)

    def suffixes(self, aov: str) -> list[str]:
        """Return the suffixes of the files that hold an AOV."""
        automatic = "png" if aov in PICTURES else "npy"
        return [f".{name}" for name in dict.fromkeys(automatic if name == "auto" else name for name in self.formats)]


def _check_names(template: str) -> None:
    try:
        fields = [name for _, name, _, _ in string.Formatter().parse(template) if name is not None]
        named_like(template, {"scene": "s", "camera": "c", "aov": "a", "index": 0, "number": 0})
    except (ValueError, KeyError, IndexError, AttributeError) as error:
        raise SettingsError(f"names '{template}': {error}; expected a text with {{{'}, {'.join(FIELDS)}}}") from None
    for name in fields:
        if name not in FIELDS:
            raise SettingsError(
                f"names '{template}': no field '{name}'; there are {', '.join(FIELDS)}.{near_miss(name, FIELDS)}"
            )
    if "number" not in fields and not {"scene"} & set(fields):
        raise SettingsError(f"names '{template}': needs {{scene}} or {{number}}, or views would overwrite each other")
    if "number" not in fields and not {"camera", "index"} & set(fields):
        raise SettingsError(
            f"names '{template}': needs {{camera}}, {{index}} or {{number}}, or views would overwrite each other"
        )


def named_like(template: str, values: Mapping[str, str | int]) -> str:
    """Return a file's name without suffix. Raises ValueError for one that leaves the output folder."""
    name = template.format_map(values)
    parts = Path(name).parts
    if not parts or Path(name).is_absolute() or ".." in parts or any(part.startswith(".") for part in parts):
        raise ValueError(f"gives '{name}'; names must stay in the output folder, and not begin with a dot")
    return name
