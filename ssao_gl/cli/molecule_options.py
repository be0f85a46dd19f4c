"""How molecules are read, as options of the command line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from ..errors import SettingsError
from ..loaders.atom_looks import COLORS_BY
from ..loaders.read_options import MoleculeOptions
from .help_pages import RARE
from .tokens import WHOLE


@Parameter(name="*", group=RARE)
@dataclass(frozen=True, kw_only=True)
class AtomOptions:
    """Which atoms of a molecule are drawn, and how."""

    assembly: Annotated[
        str | None, Parameter(help="Biological assembly, by its name in the file, as 1. [default: the atoms of the file]")
    ] = None
    model: Annotated[int | None, WHOLE, Parameter(help="Number of the model. [default: the first]")] = None
    color: Annotated[str, Parameter(help=f"Colour of atoms, by {', '.join(COLORS_BY)}.")] = "element"
    hydrogens: Annotated[bool, Parameter(help="Draw the hydrogens that the file has.")] = True
    water: Annotated[bool, Parameter(help="Draw water.", negative="")] = False
    radius_scale: Annotated[float, Parameter(help="Factor of the van der Waals radii.")] = 1.0

    def molecule(self) -> MoleculeOptions:
        """Return what they ask of the reader. Raises SettingsError."""
        if self.color not in COLORS_BY:
            raise SettingsError(f"--color {self.color}: must be {', '.join(COLORS_BY)}")
        if not 0 < self.radius_scale < float("inf"):
            raise SettingsError(f"--radius-scale {self.radius_scale:g}: must be above 0")
        return MoleculeOptions(
            assembly=self.assembly, model=self.model, color=self.color, hydrogens=self.hydrogens, water=self.water,
            radius_scale=self.radius_scale,
        )  # fmt: skip
