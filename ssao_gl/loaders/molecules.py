"""Molecules as spheres, from PDB and mmCIF files by gemmi: atoms once, the copies of a biological assembly as transforms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, near_miss
from ..scene.spheres import Spheres
from .archives import unpack
from .assemblies import Copies, copies_in_cif, copies_in_pdb
from .atom_looks import atom_colors, element_radii
from .atoms import Atoms, atoms_of, chosen_atoms, gemmi_module
from .header_checks import check_signature
from .notes import Notes
from .pdb_lines import with_coordinates
from .read_options import MoleculeOptions

PDB, CIF = ("pdb", "ent"), ("cif", "mmcif")
KINDS = (*PDB, *CIF)
"""Suffixes of molecules; each may have .gz after it."""


def molecule_kind(name: str) -> str | None:
    """Return the format of a molecule by its file's name, without .gz; None for other files. Raises SceneError for BinaryCIF."""
    kind = name.lower().removesuffix(".gz").rpartition(".")[2]
    if kind == "bcif":
        raise SceneError("BinaryCIF is not read; get the same entry as .cif or .pdb")
    return kind if kind in KINDS else None


def read_molecule(path: Path, kind: str, options: MoleculeOptions, notes: Notes) -> Sequence[Spheres]:
    """Read the atoms of a molecule. Raises SceneError."""
    data = path.read_bytes()
    check_signature(data[:64], "gz" if path.name.lower().endswith(".gz") else kind)
    if path.name.lower().endswith(".gz"):
        with path.open("rb") as file:
            data = next(iter(unpack(file, "gz", len(data), path.name).values()))
    structure, assemblies, has_asym = _parsed(data, notes)
    atoms = chosen_atoms(atoms_of(structure), options, notes)
    if options.color in ("asym", "entity") and not has_asym:
        raise SceneError(
            f"PDB files have no {options.color} ids to colour by; take 'chain' or 'element', or the entry as mmCIF"
        )
    radii = element_radii(atoms.elements) * np.float32(options.radius_scale)
    colors = atom_colors(atoms, options.color)
    if options.assembly is None:
        return [_spheres(atoms, radii, colors, slice(None), np.eye(4)[None], "")]
    known = assemblies()
    if options.assembly not in known:
        listed = ", ".join(f"{name} ({_count(atoms, parts):,} atoms)" for name, parts in known.items()) or "none"
        raise SceneError(f"has no assembly '{options.assembly}'; it has: {listed}.{near_miss(options.assembly, known)}")
    made = []
    for part in known[options.assembly]:
        members = np.isin(part.labels(atoms), part.chains)
        if members.any():
            made.append(_spheres(atoms, radii, colors, members, part.transforms(), options.assembly))
    if not made:
        raise SceneError(f"assembly '{options.assembly}' names chains of which no atom is drawn")
    return made


def _parsed(data: bytes, notes: Notes) -> tuple[Any, Callable[[], dict[str, list[Copies]]], bool]:
    """Return a structure of gemmi, what reads its assemblies, and whether it has asym ids. The content tells the format."""
    gemmi = gemmi_module()
    try:
        if not _is_cif(data):
            structure = gemmi.read_pdb_string(with_coordinates(data, notes))
            return structure, partial(copies_in_pdb, structure), False
        document = gemmi.cif.read_string(data)
        for block in document:
            if block.find_values("_atom_site.Cartn_x"):
                return gemmi.make_structure_from_block(block), partial(copies_in_cif, block), True
        for block in document:
            if block.find_values("_chem_comp_atom.atom_id"):
                return gemmi.make_structure_from_chemcomp_block(block), dict, False
    except (ValueError, RuntimeError) as error:
        told = str(error).removeprefix("data:").removeprefix("string:")
        raise SceneError(
            f"not a readable molecule: line {told}" if told[:1].isdigit() else f"not a readable molecule: {told}"
        ) from error
    raise SceneError("is a CIF file, but holds no atoms with coordinates (no _atom_site.Cartn_x)")


def _is_cif(data: bytes) -> bool:
    for line in data.splitlines()[:1000]:
        word = line.strip().lower()
        if word and not word.startswith(b"#"):
            return word.startswith((b"data_", b"global_"))
    return False


def _spheres(
    atoms: Atoms,
    radii: NDArray[np.float32],
    colors: NDArray[np.uint8],
    members: Any,
    transforms: NDArray[np.float64],
    name: str,
) -> Spheres:
    """Return some of the atoms as spheres about their middle, in 64-bit."""
    points = atoms.positions[members]
    middle = points.min(0) / 2 + points.max(0) / 2
    places = np.array(transforms)
    places[:, :3, 3] += places[:, :3, :3] @ middle
    return Spheres((points - middle).astype(np.float32), radii[members], colors[members], places, name)


def _count(atoms: Atoms, parts: Sequence[Copies]) -> int:
    return sum(int(np.isin(part.labels(atoms), part.chains).sum()) * part.count for part in parts)
