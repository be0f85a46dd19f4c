"""The table of cases, for people: what is promised, how it is measured, what the bound is and why."""

from __future__ import annotations

from collections.abc import Iterable

from .case import Case
from .catalogue import cases
from .outcomes import STEP

COLUMNS = ("case", "promise", "measured", "bound", "traps")

LEAD = """# What `ssao-gl stress` asks

Every case is asked of every registered method, on the driver at hand. Of each picture that a case draws, filtered or not,
these are asked besides: what the method computes is finite before any clamp saves it; visibility lies in 0..1 before it is
rounded; background is exactly open; depth is finite and normals are of unit length; OpenGL reports no error.

A method whose published definition breaks a promise declares it under the name of the contract, with a bound and the reason
(`exceptions` of its class); the verdict is then `declared`, with the declared bound beside the measured value. Numbers under
"traps" are those of the list of numerical traps at the end.

Written by `ssao-gl stress --list --markdown`.
"""

TRAPS = (
    "near : far of 1e-4 : 1e7",
    "reversed depth in the clip range -1..1",
    "infinite far plane",
    "depth packed as a share of the far distance",
    "squares of lengths beyond 16-bit floats",
    "reciprocals of squares below 16-bit floats",
    "tiny and huge scene units against absolute constants",
    "normalising a zero vector at the centre tap",
    "squares that underflow",
    "acos beyond 1",
    "square root of 1 - c^2 below 0",
    "a normal at right angles to its slice",
    "a slice axis that is not of unit length",
    "normals that face away",
    "tangent bases that degenerate on an axis",
    "taps outside the image",
    "no tap left",
    "samples behind the eye",
    "the camera inside a mesh",
    "a radius over the whole screen",
    "a radius under a pixel",
    "tiny, narrow and largest images",
    "odd sizes at half resolution",
    "half-resolution taps between texels",
    "filtered depth",
    "background beside surfaces",
    "skipped background under a filter matched to the noise",
    "NaN and infinity in meshes and texels",
    "NaN kept by a history",
    "a history of 8 bits that stalls",
    "8 bits before the contrast exponent; zero taken for nothing",
    "non-uniform and mirrored transforms",
    "normals of few bits",
    "parallel projections",
    "off-centre and tiled projections",
    "coplanar and doubled faces",
    "thin wires",
    "cut-outs and blending",
    "shifts by 32 bits",
    "noise at large coordinates",
    "depth that differs between passes",
    "denormal numbers flushed to zero",
    "sums over images that overflow",
    "powers of zero and of negative numbers",
    "a texture read while it is drawn into",
)
"""The list of numerical traps, from number 1."""


def rows(chosen: Iterable[Case]) -> list[tuple[str, ...]]:
    """Return the table of some cases, by :data:`COLUMNS`."""
    return [(case.name, case.promise, case.unit, bound(case), " ".join(map(str, case.traps))) for case in chosen]


def bound(case: Case) -> str:
    """Return the bound of a case in words, with the contract under which it may be broken."""
    steps = case.bound / STEP
    number = f"{steps:.0f}/255" if 0.9 < steps < 9 and abs(steps - round(steps)) < 1e-3 else f"{case.bound:g}"
    why = f" ({case.why})" if case.why else ""
    contract = f"; contract '{case.contract}'" if case.contract else ""
    return f"{number}{why}{contract}"


def case_table_markdown() -> str:
    """Return the whole page."""
    groups = dict.fromkeys(case.group for case in cases().values())
    parts = [LEAD]
    for group in groups:
        chosen = [case for case in cases().values() if case.group == group]
        lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
        lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows(chosen)]
        parts.append(f"## {group[0].upper()}{group[1:]}\n\n" + "\n".join(lines) + "\n")
    listed = [f"{number}. {trap}: {_where(number)}" for number, trap in enumerate(TRAPS, 1)]
    parts.append("## The traps, and the cases that spring them\n\n" + "\n".join(listed) + "\n")
    return "\n".join(parts)


def _where(trap: int) -> str:
    return ", ".join(f"`{case.name}`" for case in cases().values() if trap in case.traps)
