"""How a picture is lit, as options of the command line."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import SettingsError
from ..io.panorama_files import load_panorama
from ..passes.light import INDIRECT
from ..pipeline.light import ENVIRONMENTS, TONES, Light
from ..pipeline.settings import Settings
from ..scene.harmonics import projected
from .help_pages import RARE
from .tokens import is_number


@Parameter(name="*", group=RARE)
@dataclass(frozen=True, kw_only=True)
class LightOptions:
    """Lamps, shadows and light from all around; without any of them the plain light of before."""

    light: Annotated[
        str | None,
        Parameter(
            help="Key light: azimuth to the right of the viewer and elevation above the horizon, degrees, like -40,50; or scene: the file's own lights. [default: none]",
            allow_leading_hyphen=True,
        ),
    ] = None
    shadows: Annotated[bool, Parameter(help="Let the key light cast shadows.", negative="")] = False
    environment: Annotated[
        str | None,
        Parameter(
            help=f"Light from all around: {', '.join(ENVIRONMENTS)}, or an equirectangular picture (EXR, HDR, PNG). [default: sky with any other option of light]"
        ),
    ] = None

    indirect: Annotated[
        str | None,
        Parameter(
            help=f"Light that bounced once: {', '.join(INDIRECT)}; bitmask lets colours bleed, ssdo and rsm (with --shadows) are there to compare. [default: none]",
        ),
    ] = None
    tone: Annotated[
        str | None, Parameter(help=f"Curve from linear light to the picture: {', '.join(TONES)}. [default: none]")
    ] = None

    def onto(self, settings: Settings) -> Settings:
        """Return settings with the light that was asked for. Raises SettingsError, FormatError."""
        if self == LightOptions():
            return settings
        alone = (
            self.environment is not None and self.light is None and not self.shadows
        )  # an environment needs no key light beside it
        light = settings.light or (Light(intensity=0.0) if alone else Light())
        plain = {name: value for name in ("indirect", "tone") if (value := getattr(self, name)) is not None}
        light = dataclasses.replace(light, **self._key(), **self._environment(), **plain)
        return dataclasses.replace(settings, light=dataclasses.replace(light, shadows=True) if self.shadows else light)

    def _key(self) -> dict[str, Any]:
        if self.light is None:
            return {}
        if self.light == "scene":
            return {"lamps": "scene"}
        parts = self.light.split(",")
        if len(parts) != 2 or not all(map(is_number, parts)):
            raise SettingsError(
                f"--light {self.light[:40]}: must be azimuth,elevation in degrees, like -40,50, or scene for the lights of the file"
            )
        return {"lamps": "key", "azimuth": float(parts[0]), "elevation": float(parts[1])}

    def _environment(self) -> dict[str, Any]:
        if self.environment is None:
            return {}
        if self.environment in ENVIRONMENTS:
            return {"environment": self.environment}
        path = Path(self.environment)
        if not path.suffix:
            raise SettingsError(
                f"--environment {self.environment[:60]}: must be {', '.join(ENVIRONMENTS)}, or the file of an equirectangular picture"
            )
        return {"environment": "given", "coefficients": projected(load_panorama(path))}
