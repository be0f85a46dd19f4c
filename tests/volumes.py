"""Little volumes for tests, whose surfaces are known on paper."""

from __future__ import annotations

import numpy as np

import ssao_gl as ao
from ssao_gl.scene.transfer import Transfer, TransferPoint

F64 = np.ndarray


def grid(shape: tuple[int, int, int], affine: F64) -> F64:
    """World positions (x, y, z, 3) of voxel centres."""
    index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1)
    return index @ affine[:3, :3].T + affine[:3, 3]


def ball(radius: float = 1.0, n: int = 48, center: tuple[float, float, float] = (0, 0, 0)) -> ao.Volume:
    """A ball as signed distances, within 1.6 radii about its centre."""
    h = 3.2 * radius / (n - 1)
    affine = np.diag([h, h, h, 1.0])
    affine[:3, 3] = np.array(center) - 1.6 * radius
    distance = radius - np.linalg.norm(grid((n, n, n), affine) - center, axis=-1)
    return ao.Volume(distance.astype(np.float32), affine, iso=0.0)


def half_space(affine: F64, normal: F64, point: F64, shape: tuple[int, int, int] = (9, 8, 10)) -> ao.Volume:
    """What lies below a plane, as distances: linear, and so met exactly by rays, whatever the affine."""
    return ao.Volume((point - grid(shape, affine)) @ normal, affine, iso=0.0)


def slab(opacity: float, thickness: int = 4, n: int = 16, unit: float | None = None, step: float = 0.5) -> ao.Volume:
    """Voxels of 1 across z = 0 among voxels of 0, each side of length 1, under a transfer function with one step."""
    values = np.zeros((n, n, n), np.uint8)
    values[..., n // 2 - thickness // 2 : n // 2 + thickness // 2] = 1
    affine = np.eye(4)
    affine[:3, 3] = -(n - 1) / 2
    points = [TransferPoint(0.49, 0.0, (1, 0, 0)), TransferPoint(0.51, opacity, (1, 0, 0))]
    return ao.Volume(values, affine, transfer=Transfer(points, unit, step))
