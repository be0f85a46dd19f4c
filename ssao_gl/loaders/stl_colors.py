"""Colours of binary STL files: 15 bits a triangle, as VisCAM and Magics write them. No standard has them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

OWN = 0x8000


def face_colors(header: bytes, words: NDArray[np.uint16]) -> NDArray[np.uint8] | None:
    """Return (m, 4) uint8 sRGB of the attributes (m,) of all triangles, or None when they hold none.

    VisCAM sets the highest bit where a triangle has a colour, and has blue in the lowest five. Magics writes ``COLOR=`` and
    the whole's colour in the header, clears the highest bit where a triangle has its own, and has red in the lowest five.
    """
    magics = b"COLOR=" in header[:80]
    if not words.any() and not magics:
        return None
    own = (words & OWN == 0) & words.any() if magics else words & OWN != 0
    if not own.any() and not magics:
        return None
    parts = np.stack([(words >> shift) & 31 for shift in ((0, 5, 10) if magics else (10, 5, 0))], 1)
    colors = np.full((len(words), 4), 255, np.uint8)
    colors[:, :3] = np.round(parts * (255 / 31))
    at = header.find(b"COLOR=") + 6
    whole = list(header[at : at + 3]) if magics and len(header) >= at + 3 else [204, 204, 204]
    colors[~own, :3] = whole
    return colors
