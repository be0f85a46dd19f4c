"""Atoms of a molecule as arrays, and which of them are drawn."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .notes import Notes
from .read_options import MoleculeOptions

WATER = (b"HOH", b"DOD", b"WAT", b"H2O", b"TIP", b"TIP3", b"SOL")
HYDROGEN = (b"H", b"D")
Words = NDArray[np.bytes_]


@dataclass(frozen=True, eq=False)
class Atoms:
    """n atoms. positions: (n, 3) float64, angstroms; all others (n,).

    chains: as authors name them; asyms, entities: as mmCIF files do, empty in others. places: what stands at one place of a
    chain under several alternatives has the same number.
    """

    positions: NDArray[np.float64]
    elements: Words
    chains: Words
    asyms: Words
    entities: Words
    residues: Words
    alternatives: NDArray[np.int8]
    occupancies: NDArray[np.float32]
    places: NDArray[np.int64]
    models: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.positions)

    def only(self, which: NDArray[np.bool_]) -> Atoms:
        """Return some of them."""
        return Atoms(*(getattr(self, field.name)[which] for field in dataclasses.fields(self)))


def atoms_of(structure: Any) -> Atoms:
    """Return the atoms of a structure of gemmi."""
    flat = gemmi_module().FlatStructure(structure)
    chains, residues, names = (_words(getattr(flat, name)) for name in ("chain_ids", "residue_names", "atom_names"))
    spots: Any = np.rec.fromarrays([flat.model_num, chains, flat.resnums, flat.icodes, names])
    places = np.unique(spots, return_inverse=True)[1]
    return Atoms(
        np.asarray(flat.pos, np.float64).reshape(-1, 3), np.char.upper(np.asarray(flat.element_names, "S2")), chains,
        _words(flat.subchains), _words(flat.entity_ids), residues, np.asarray(flat.altlocs), np.asarray(flat.occ),
        np.asarray(places).ravel(), np.asarray(flat.model_num),
    )  # fmt: skip


def gemmi_module() -> Any:
    """Return gemmi. Raises SceneError without it."""
    try:
        import gemmi
    except ImportError:
        raise SceneError("reading molecules needs the package gemmi: pip install 'ssao_gl[molecules]'") from None
    return gemmi


def _words(characters: Any) -> Words:
    """Return rows of characters (n, 8) as words (n,)."""
    rows = np.ascontiguousarray(characters).reshape(-1, np.shape(characters)[-1])
    return rows.view(f"S{rows.shape[1]}").ravel()


def chosen_atoms(atoms: Atoms, options: MoleculeOptions, notes: Notes) -> Atoms:
    """Return the atoms that are drawn: of one model, one alternative at each place, with or without hydrogens and water.

    Raises SceneError when none is left.
    """
    if not len(atoms):
        raise SceneError("was read, but holds no atoms")
    models = list(dict.fromkeys(atoms.models.tolist()))
    model = models[0] if options.model is None else options.model
    if model not in models:
        raise SceneError(
            f"has no model {model}; it has: {', '.join(map(str, models[:20]))}{' ...' if len(models) > 20 else ''}"
        )
    if len(models) > 1 and options.model is None:
        notes.add(f"holds {len(models)} models; model {model} is drawn (--model draws another)")
    atoms = atoms.only(atoms.models == model)
    placed = np.asarray(np.isfinite(atoms.positions).all(1))
    if not placed.all():
        first = int(np.flatnonzero(~placed)[0]) + 1
        if not placed.any():
            raise SceneError("none of its atoms has coordinates that are numbers")
        notes.add(f"{int((~placed).sum())} atoms are left out: their coordinates are no numbers (the first is atom {first})")
        atoms = atoms.only(placed)
    atoms = atoms.only(_first_alternatives(atoms))
    water = np.isin(atoms.residues, WATER)
    hidden = np.zeros(len(atoms), bool)
    if not options.water:
        hidden |= water
    if not options.hydrogens:
        hidden |= np.isin(atoms.elements, HYDROGEN)
    if hidden.all():
        raise SceneError(f"has no atoms but {'water' if water.all() else 'water and hydrogens'}; add --water or --hydrogens")
    return atoms.only(~hidden)


def _first_alternatives(atoms: Atoms) -> NDArray[np.bool_]:
    """Which atoms (n,) stay: of several at one place that of the highest occupancy, of equal ones the first by its label."""
    kept = atoms.alternatives == 0
    order = np.lexsort((atoms.alternatives, -atoms.occupancies, atoms.places))
    order = order[~kept[order]]
    first = np.diff(atoms.places[order], prepend=-1) != 0
    kept[order[first]] = True
    return np.asarray(kept)
