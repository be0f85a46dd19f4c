"""The lecture's shader against an independent float64 version in numpy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import ssao_gl as ao
from ssao_gl.loaders.camera_files import load_cameras
from ssao_gl.loaders.load import load_scene
from ssao_gl.scene.camera import Camera
from ssao_gl.scene.model import Scene

from ..conftest import real_scenes

SIZE = (320, 180)
Array = NDArray[np.float64]


def lecture(z: Array, normal: Array, projection: Array, far: float, samples: Array, tile: Array, radius: float) -> Array:
    """Visibility (h, w) from linear depth (0 = background) and view-space normals, rows from the bottom, all in float64."""
    h, w = z.shape
    depth = np.where(z > 0, z / far, 1.0)
    inverse = np.linalg.inv(projection)
    u, v = np.meshgrid((np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h)
    uv = np.stack([u, v], -1)

    def fetch(image: Array, at: Array) -> Array:
        x = np.clip(np.floor(at[..., 0] * w).astype(int), 0, w - 1)
        y = np.clip(np.floor(at[..., 1] * h).astype(int), 0, h - 1)
        return image[y, x]

    def unproject(at: Array, d: Array) -> Array:
        clip = np.concatenate([2 * at - 1, np.ones((h, w, 2))], -1) @ inverse.T
        return clip[..., :3] / clip[..., 3:] * d[..., None]

    p = unproject(uv, depth)
    turn = tile[np.arange(h)[:, None] % len(tile), np.arange(w)[None] % len(tile)]
    total = np.zeros((h, w))
    for s in samples:
        reflected = s - 2 * (turn @ s)[..., None] * turn
        at = uv + radius * (1 - depth)[..., None] * reflected
        d_q = fetch(depth, at)
        direction = unproject(at, d_q) - p
        length = np.linalg.norm(direction, axis=-1, keepdims=True)
        direction = np.divide(direction, length, out=np.zeros_like(direction), where=length > 0)
        t = np.clip((direction * normal).sum(-1), 0, 1)
        a = t * t * (3 - 2 * t)
        b = 1 - (normal * fetch(normal, at)).sum(-1)
        total += a * b * (np.abs(d_q - depth) <= 0.05)
    return np.where(z > 0, np.clip(1 - total / len(samples), 0, 1), 1.0)


def check(renderer: ao.Renderer, scene: Scene, camera: Camera, samples: int) -> None:
    method = ao.Lecture(samples=samples)
    picture = renderer.render(
        scene,
        camera,
        SIZE,
        ao.Settings(method=method, blur=None, normals="shading"),
        aovs=("visibility", "depth", "normal"),
        checked=True,
    )
    normal = np.where(picture.depth[..., None] > 0, picture.normal, [0.0, 0, 1])  # what the G-buffer is cleared to
    view = camera.view(SIZE)
    expected = lecture(
        picture.depth[::-1].astype(np.float64), normal[::-1].astype(np.float64), view.projection, view.far,
        ao.Kernel(count=samples).points().astype(np.float64), ao.Rotation().vectors().astype(np.float64), method.radius,
    )[::-1]  # fmt: skip
    assert expected.std() > 0.01
    assert (np.abs(picture.visibility - expected) <= 2 / 255).mean() >= 0.999


@pytest.mark.parametrize("samples", [4, 8, 16])
def test_agrees_with_numpy(renderer: ao.Renderer, embedded: Scene, samples: int) -> None:
    check(renderer, embedded, embedded.cameras[0], samples)


@pytest.mark.parametrize("samples", [4, 8, 16])
@pytest.mark.parametrize("path", real_scenes(), ids=lambda path: path.stem)
def test_agrees_with_numpy_on_real_scenes(any_renderer: ao.Renderer, path: Path, samples: int) -> None:
    scene = load_scene(path)
    for camera in load_cameras(path.with_suffix(".cam.json")):
        check(any_renderer, scene, camera, samples)
