"""Radii and colours of atoms."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, near_miss
from .atoms import Atoms, Words, gemmi_module

RADII: Mapping[bytes, float] = {b"H": 1.10, b"D": 1.10, b"C": 1.70, b"N": 1.55, b"O": 1.52, b"S": 1.80, b"P": 1.80}
"""Van der Waals radii, angstroms (Bondi 1964; hydrogen by Rowland & Taylor 1996); others are gemmi's."""
UNKNOWN = 1.70

COLORS_BY = ("element", "chain", "asym", "entity")
ELEMENTS: Mapping[bytes, int] = {
    b"H": 0xFFFFFF, b"D": 0xFFFFC0, b"C": 0x909090, b"N": 0x3050F8, b"O": 0xFF0D0D, b"F": 0x90E050, b"NA": 0xAB5CF2,
    b"MG": 0x8AFF00, b"P": 0xFF8000, b"S": 0xFFFF30, b"CL": 0x1FF01F, b"K": 0x8F40D4, b"CA": 0x3DFF00, b"MN": 0x9C7AC7,
    b"FE": 0xE06633, b"CO": 0xF090A0, b"NI": 0x50D050, b"CU": 0xC88033, b"ZN": 0x7D80B0, b"SE": 0xFFA100, b"BR": 0xA62929,
    b"I": 0x940094, b"SI": 0xF0C8A0, b"B": 0xFFB5B5,
}  # fmt: skip
"""The colours of Jmol, after those of Corey, Pauling and Koltun."""
OTHER = 0xFF1493
GROUPS = (
    0x66C2A5, 0xFC8D62, 0x8DA0CB, 0xE78AC3, 0xA6D854, 0xFFD92F, 0xE5C494, 0xB3B3B3, 0x8DD3C7, 0xFB8072, 0x80B1D3, 0xBC80BD
)  # fmt: skip
"""Colours for groups of atoms, in the order in which a file names them (Brewer's Set2 and Set3)."""


def element_radii(elements: Words) -> NDArray[np.float32]:
    """Return van der Waals radii (n,), angstroms, of elements in upper case. Raises SceneError without gemmi."""
    element = gemmi_module().Element
    kinds, which = np.unique(elements, return_inverse=True)
    radii = [RADII.get(kind) or _published(element(kind.decode("ascii", "replace"))) for kind in kinds]
    return np.array(radii, np.float32)[which]


def _published(element: object) -> float:
    known = getattr(element, "atomic_number", 0) > 0
    return float(getattr(element, "vdw_r", UNKNOWN)) if known else UNKNOWN


def atom_colors(atoms: Atoms, by: str) -> NDArray[np.uint8]:
    """Return sRGB colours (n, 4) by element, chain, asym or entity. Raises SceneError."""
    if by not in COLORS_BY:
        raise SceneError(f"cannot colour by '{by}'; must be {', '.join(COLORS_BY)}.{near_miss(by, COLORS_BY)}")
    if by == "element":
        return element_colors(atoms.elements)
    groups: Words = {"chain": atoms.chains, "asym": atoms.asyms, "entity": atoms.entities}[by]
    if not (groups != b"").any():
        raise SceneError(f"names no {by} to colour by; take {' or '.join(one for one in COLORS_BY if one != by)}")
    _, first, which = np.unique(groups, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    return _rgba(GROUPS)[rank[which] % len(GROUPS)]


def element_colors(elements: Words) -> NDArray[np.uint8]:
    """Return sRGB colours (n, 4) of elements in upper case."""
    kinds, which = np.unique(elements, return_inverse=True)
    return _rgba([ELEMENTS.get(kind, OTHER) for kind in kinds])[which]


def _rgba(codes: list[int] | tuple[int, ...]) -> NDArray[np.uint8]:
    return np.array([[code >> 16, code >> 8 & 255, code & 255, 255] for code in codes], np.uint8)
