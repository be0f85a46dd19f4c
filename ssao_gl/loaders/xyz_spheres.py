"""XYZ files of spheres: of atoms by their element, as chemists write them, or of points with a radius."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..scene.spheres import Spheres
from .atom_looks import element_colors, element_radii
from .read_options import MoleculeOptions

Rows = list[list[str]]


def read_xyz_spheres(path: Path, options: MoleculeOptions) -> Spheres | None:
    """Read the spheres of a file; None for one of bare or of coloured points. Raises SceneError.

    Either a count, a line of comment, and lines ``element x y z`` (of the first frame), or lines ``x y z radius``.
    """
    lines = path.read_bytes().decode("utf-8", "replace").splitlines()
    first = lines[0].split() if lines else []
    if len(first) == 1 and first[0].isdigit():
        count = int(first[0])
        rows = [line.split() for line in lines[2 : 2 + count]]
        if len(rows) < count:
            raise SceneError(f"announces {count} atoms, but has {len(rows)}; it is truncated or broken")
        words = np.array([row[0].encode()[:8].upper() if row else b"" for row in rows])
        points = _numbers(rows, slice(1, 4), 3)
        return Spheres.from_points(
            points, element_radii(words) * options.radius_scale, element_colors(words), name=path.stem
        )  # fmt: skip
    rows = [line.replace(",", " ").split() for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not rows or len(rows[0]) != 4:
        return None
    values = _numbers(rows, slice(0, 4), 1)
    return Spheres.from_points(values[:, :3], values[:, 3] * options.radius_scale, name=path.stem)


def _numbers(rows: Rows, columns: slice, line: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return some columns as numbers. ``line``: of the first row in the file, for the error."""
    width = columns.stop - columns.start
    for number, row in enumerate(rows, line):
        try:
            if len([float(word) for word in row[columns]]) != width:
                raise ValueError
        except ValueError:
            raise SceneError(f"line {number}: '{' '.join(row)[:60]}'; expected {width} numbers like those before") from None
    return np.array([row[columns] for row in rows], np.float64).reshape(len(rows), width)
