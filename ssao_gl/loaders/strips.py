"""Strips and fans of triangles, cut at restarts (OpenGL ES 3.0, 2.6 and 2.8)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]


def strip_triangles(indices: Indices, restart: int = -1) -> Indices:
    """Triangles (m, 3) of strips; every second one is turned, so that all face one way. ``restart`` begins another strip."""
    return _joined(indices, restart, _strip)


def fan_triangles(indices: Indices, restart: int = -1) -> Indices:
    """Triangles (m, 3) of fans about their first vertex; ``restart`` begins another fan."""
    return _joined(indices, restart, _fan)


def _joined(indices: Indices, restart: int, one: Callable[[Indices], Indices]) -> Indices:
    cuts = np.flatnonzero(indices == restart)
    starts, ends = np.append(0, cuts + 1), np.append(cuts, len(indices))
    long = ends - starts > 2
    parts = [one(indices[start:end]) for start, end in zip(starts[long], ends[long], strict=True)]
    return np.concatenate(parts) if parts else np.zeros((0, 3), np.int64)


def _strip(indices: Indices) -> Indices:
    triangles = np.stack([indices[:-2], indices[1:-1], indices[2:]], 1)
    triangles[1::2] = triangles[1::2, ::-1]
    return triangles


def _fan(indices: Indices) -> Indices:
    first = np.full(len(indices) - 2, indices[0])
    return np.stack([first, indices[1:-1], indices[2:]], 1)
