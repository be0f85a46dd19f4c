"""Atoms of PDB files whose coordinates are no numbers: gemmi would take them for 0."""

from __future__ import annotations

from ..errors import SceneError
from .notes import Notes

ATOMS = (b"ATOM  ", b"HETATM")
COLUMNS = ((30, 38), (38, 46), (46, 54))


def with_coordinates(data: bytes, notes: Notes) -> bytes:
    """Return a PDB file without such atoms. Raises SceneError when none is left."""
    lines = data.splitlines()
    atoms = [number for number, line in enumerate(lines) if line[:6] in ATOMS]
    bad = [number for number in atoms if not _placed(lines[number])]
    if not bad:
        return data
    if len(bad) == len(atoms):
        raise SceneError("none of its atoms has coordinates that are numbers")
    notes.add(f"{len(bad)} atoms are left out: their coordinates are no numbers (the first is in line {bad[0] + 1})")
    gone = set(bad)
    return b"\n".join(line for number, line in enumerate(lines) if number not in gone)


def _placed(line: bytes) -> bool:
    try:
        for start, end in COLUMNS:
            float(line[start:end])
    except ValueError:
        return False
    return True
