"""What is seen of volumes, as options of the command line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from ..errors import SettingsError
from ..loaders.read_options import VolumeOptions
from ..loaders.transfer_files import PRESETS, load_transfer
from .help_pages import RARE
from .tokens import WHOLE


@Parameter(name="*", group=RARE)
@dataclass(frozen=True, kw_only=True)
class VoxelOptions:
    """What is seen of a volume."""

    iso: Annotated[
        float | None,
        Parameter(
            help="Level of the iso-surface, in units of the data. [default: by Otsu's method]", allow_leading_hyphen=True
        ),
    ] = None
    transfer: Annotated[
        str | None,
        Parameter(help=f"Transfer function: {', '.join(PRESETS)}, or a TOML file. [default: none, an iso-surface]"),
    ] = None
    frame: Annotated[int | None, WHOLE, Parameter(help="Which volume of a series, from 0. [default: the only one]")] = None

    def volume(self) -> VolumeOptions:
        """Return what they ask of the reader. Raises SettingsError, SceneError."""
        if self.iso is not None and self.transfer is not None:
            raise SettingsError("--iso and --transfer exclude each other: a volume is seen as a surface or by its opacities")
        return VolumeOptions(iso=self.iso, transfer=load_transfer(self.transfer) if self.transfer else None, frame=self.frame)
