"""Biological assemblies: which chains stand where, how often."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .atoms import Atoms, Words

MAX_COPIES = 200_000
"""Of one group of chains; the largest capsids of the archive have a few thousand."""
SKEW = 1e-2
"""How far an operator's columns may be from unit length and right angles: files round them to some decimals."""
_GROUP = re.compile(r"\(([^()]*)\)|([^()]+)")

Operators = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Copies:
    """Chains that are copied together: by products of operators, one of each group, the right one first."""

    chains: Words
    by_asym: bool
    groups: tuple[tuple[str, ...], ...]
    operators: Operators

    @property
    def count(self) -> int:
        """How many copies there are."""
        return math.prod(len(group) for group in self.groups)

    def labels(self, atoms: Atoms) -> Words:
        """Return what ``chains`` names, of each atom."""
        return atoms.asyms if self.by_asym else atoms.chains

    def transforms(self) -> NDArray[np.float64]:
        """Return the transforms (k, 4, 4). Raises SceneError for operators that are missing, or no turns and shifts."""
        if self.count > MAX_COPIES:
            raise SceneError(f"an assembly of {self.count:,} copies; at most {MAX_COPIES:,} are drawn")
        rigid = {name: self._rigid(name) for name in set(itertools.chain.from_iterable(self.groups))}
        made = np.eye(4)[None]
        for group in self.groups:
            factors = np.array([rigid[name] for name in group])
            made = (made[:, None] @ factors[None]).reshape(-1, 4, 4)
        return made

    def _rigid(self, name: str) -> NDArray[np.float64]:
        """Return an operator without what rounding did to it."""
        if name not in self.operators:
            raise SceneError(f"an assembly asks for operator '{name}', which the file does not have")
        matrix = self.operators[name].copy()
        if not np.isfinite(matrix).all():
            raise SceneError(f"operator '{name}' of an assembly has entries that are no numbers")
        u, sizes, v = np.linalg.svd(matrix[:3, :3])
        if np.abs(sizes - 1).max() > SKEW:
            raise SceneError(
                f"operator '{name}' of an assembly is no turn and shift: it changes lengths by {sizes.min():.3g} to {sizes.max():.3g}"
            )
        matrix[:3, :3] = u @ v
        return matrix


def operator_groups(expression: str) -> tuple[tuple[str, ...], ...]:
    """Return the operators of an expression of mmCIF such as ``1``, ``1,2,5``, ``(1-4)`` or ``(X0)(1-60,P)``, group by group.

    Raises SceneError.
    """
    text = expression.replace(" ", "").replace("\n", "")
    found = list(_GROUP.finditer(text))
    if not found or sum(len(match[0]) for match in found) != len(text):
        raise SceneError(f"the operators '{expression[:60]}' of an assembly cannot be read; expected a form like (1-60)(P)")
    return tuple(tuple(_listed(match[1] if match[1] is not None else match[2], expression)) for match in found)


def _listed(group: str, expression: str) -> list[str]:
    names: list[str] = []
    for part in group.split(","):
        first, dash, last = part.partition("-")
        if dash and first.isdigit() and last.isdigit() and 0 <= int(last) - int(first) < MAX_COPIES:
            names += [str(number) for number in range(int(first), int(last) + 1)]
        elif part and not dash:
            names.append(part)
        else:
            raise SceneError(
                f"the operators '{expression[:60]}' of an assembly cannot be read: '{part}' is no name and no range"
            )
    return names


def copies_in_cif(block: Any) -> dict[str, list[Copies]]:
    """Return assembly -> copies, from a block of gemmi.cif. Raises SceneError."""
    from gemmi import cif

    entries = [f"matrix[{i}][{j}]" for i in (1, 2, 3) for j in (1, 2, 3)] + [f"vector[{i}]" for i in (1, 2, 3)]
    operators = {}
    for row in block.find("_pdbx_struct_oper_list.", ["id", *entries]):
        values = [cif.as_number(row[number]) for number in range(1, 13)]
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = np.reshape(values[:9], (3, 3)), values[9:]
        operators[cif.as_string(row[0])] = matrix
    found: dict[str, list[Copies]] = {}
    for row in block.find("_pdbx_struct_assembly_gen.", ["assembly_id", "oper_expression", "asym_id_list"]):
        name, expression, asyms = (cif.as_string(value) for value in row)
        chains = np.array([word.strip().encode() for word in asyms.split(",")])
        found.setdefault(name, []).append(Copies(chains, True, operator_groups(expression), operators))
    return found


def copies_in_pdb(structure: Any) -> dict[str, list[Copies]]:
    """Return assembly -> copies, from REMARK 350 of a PDB file as gemmi has read it."""
    found: dict[str, list[Copies]] = {}
    for assembly in structure.assemblies:
        parts = found.setdefault(assembly.name, [])
        for generator in assembly.generators:
            operators = {}
            for number, operator in enumerate(generator.operators, 1):
                matrix = np.eye(4)
                matrix[:3, :3], matrix[:3, 3] = operator.transform.mat.tolist(), operator.transform.vec.tolist()
                operators[str(number)] = matrix
            chains = np.array([name.encode() for name in generator.chains])
            parts.append(Copies(chains, False, (tuple(operators),), operators))
    return found
