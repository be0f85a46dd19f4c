"""The Z-order curve (Morton 1966), which goes through a cell and all of its parts before it goes on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BITS = 21
"""Of each of three coordinates, at most."""
_SPREAD = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)


def along_z_order(cells: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return the place of each cell (n, 3), of ``BITS`` bits an axis, along the curve: x has the lowest bit."""
    for shift, mask in _SPREAD:  # two zero bits between one bit and the next
        cells = (cells | cells << np.uint64(shift)) & np.uint64(mask)
    codes: NDArray[np.uint64] = cells[:, 0] | cells[:, 1] << np.uint64(1) | cells[:, 2] << np.uint64(2)
    return codes
