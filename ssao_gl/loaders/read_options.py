"""What a caller asks of the readers of scene files."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..errors import SceneError
from ..scene.transfer import Transfer


@dataclass(frozen=True, kw_only=True)
class MoleculeOptions:
    """How a molecule is read.

    assembly: name of a biological assembly; None for the atoms of the file as they are. model: number of the model; None for
    the first. color: element, chain (as authors name them), asym or entity (as mmCIF files do). hydrogens, water: whether
    those that the file has are drawn. radius_scale: factor of the van der Waals radii. Raises SceneError.
    """

    assembly: str | None = None
    model: int | None = None
    color: str = "element"
    hydrogens: bool = True
    water: bool = False
    radius_scale: float = 1.0

    def __post_init__(self) -> None:
        if not 0 < self.radius_scale < math.inf:
            raise SceneError(f"radius_scale {self.radius_scale:g}: must be above 0")


@dataclass(frozen=True, kw_only=True)
class VolumeOptions:
    """What is seen of a volume, and which one of a series is read.

    iso: level of the iso-surface, in units of the data. transfer: a transfer function instead; with neither the level is Otsu's.
    frame: number of the volume, None for the only one.
    """

    iso: float | None = None
    transfer: Transfer | None = None
    frame: int | None = None


@dataclass(frozen=True, kw_only=True)
class ReadOptions:
    """See :func:`ssao_gl.load_scene`."""

    crease: float = math.radians(40)
    animation: str | None = None
    time: float = 0.0
    point_size: float | None = None
    molecule: MoleculeOptions = field(default_factory=MoleculeOptions)
    volume: VolumeOptions = field(default_factory=VolumeOptions)

    @property
    def point_radius(self) -> float | None:
        """Half the size of points, scene units."""
        return None if self.point_size is None else self.point_size / 2
