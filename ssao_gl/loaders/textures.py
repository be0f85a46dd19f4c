"""Textures, sampled at the vertices of meshes; only as many texels are unpacked as their files can mean."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import one_line
from ..io.images import PICTURES

LOG = logging.getLogger("ssao_gl")

FREE, RATIO = 1 << 26, 16
"""Texels that the pictures of a scene may have (8192 x 8192), or 16 a byte of their files if that is more."""

Colors = NDArray[np.uint8]


def sample(meshes: Mapping[str, Any]) -> dict[str, Colors]:
    """Colours (n, 4) uint8 sRGB by name, of those of trimesh's ``meshes`` that have a texture and can use it.

    The nearest texel, as trimesh takes it. A texture that cannot be used is left out with a warning.
    """
    users: dict[int, tuple[Any, list[str]]] = {}
    for name, mesh in meshes.items():
        image: Any = _image(mesh)
        uv: Any = getattr(mesh.visual, "uv", None)
        if image is not None and np.ndim(uv) == 2 and len(uv) == len(mesh.vertices):
            users.setdefault(id(image), (image, []))[1].append(name)
    found: dict[str, Colors] = {}
    left = max(FREE, RATIO * sum(_bytes(image) for image, _ in users.values()))
    for image, names in users.values():
        left -= image.width * image.height
        try:
            found |= _sampled(image, left, {name: meshes[name].visual.uv for name in names})
        except Exception as error:
            what = ", ".join(f"'{one_line(name, 50)}'" for name in names[:3]) + (", ..." if len(names) > 3 else "")
            LOG.warning("mesh %s: drawn without its texture (%s)", what, one_line(error))
    return found


def _sampled(image: Any, left: int, uvs: Mapping[str, NDArray[Any]]) -> list[tuple[str, Colors]]:
    if image.format not in (None, *PICTURES):
        raise ValueError(f"{image.format} pictures are not read")
    if left < 0:
        raise ValueError(f"its {image.width}x{image.height} texels are far more than its file can mean")
    pixels = np.asarray(image.convert("RGBA"))
    return [(name, _nearest(pixels, np.nan_to_num(np.asarray(uv, np.float64), posinf=0, neginf=0))) for name, uv in uvs.items()]


def _nearest(pixels: Colors, uv: NDArray[np.float64]) -> Colors:
    h, w = pixels.shape[:2]
    x = (uv[:, 0] * (w - 1)) % w
    y = ((1 - uv[:, 1]) * (h - 1)) % h
    texels: Colors = pixels[y.round().astype(np.int64) % h, x.round().astype(np.int64) % w]
    return texels


def _image(mesh: Any) -> Any:
    material = getattr(mesh.visual, "material", None) if mesh.visual is not None else None
    return getattr(material, "baseColorTexture", None) or getattr(material, "image", None)


def _bytes(image: Any) -> int:
    """Size of the file that an image was opened from; of one that was made in memory, of its texels."""
    stream: Any = getattr(image, "fp", None)
    try:
        at = stream.tell()
        size = stream.seek(0, 2)
        stream.seek(at)
        return int(size)
    except (AttributeError, OSError, ValueError):
        return int(image.width * image.height)
