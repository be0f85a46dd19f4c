"""Visibility that a primitive of glTF keeps: an attribute _AO, an occlusion texture, or vertex colours that are grey."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.baked_visibility import BakedVisibility
from .gltf_document import Tree
from .gltf_materials import Materials, placed

AO = "_AO"
"""The attribute of a float a vertex that ``ssao-gl bake --attribute _AO`` writes."""
GREY = 1 / 512
"""Largest difference of the channels of a grey: of what 8 bits round."""


def baked_visibility(
    attributes: Mapping[str, NDArray[Any]], colors: NDArray[Any] | None, materials: Materials, primitive: Tree
) -> BakedVisibility | None:
    """Return what a primitive keeps. ``colors``: (n, 3 or 4) its COLOR_0, linear, where it has some that are drawn."""
    kept = attributes.get(AO)
    if kept is not None and kept.shape[1] == 1:
        return BakedVisibility(_within(kept[:, 0]))
    occlusion = materials.occlusion(primitive["material"]) if "material" in primitive else None
    if occlusion is not None:
        uv = attributes.get(f"TEXCOORD_{occlusion.coordinates}")
        if uv is not None and uv.shape[1] == 2:
            rows = np.nan_to_num(placed(uv, occlusion.transform).astype(np.float32), posinf=0, neginf=0)
            return BakedVisibility(rows, occlusion.texture, occlusion.strength)
    if colors is None or not _is_grey(colors):
        return None
    r, g, b = materials.surface(primitive["material"]).material.base_color[:3] if "material" in primitive else (1.0, 1.0, 1.0)
    return BakedVisibility(_within(colors[:, 0]), base_color=(r, g, b))


def _is_grey(colors: NDArray[Any]) -> bool:
    """Whether colours are shades of grey, and not white alone."""
    rgb = colors[:, :3]
    return bool(np.ptp(rgb, axis=1).max(initial=0) <= GREY and rgb.min(initial=1) < 1)


def _within(rows: NDArray[Any]) -> NDArray[np.float32]:
    """As visibility: what is no number is open."""
    return np.asarray(np.clip(np.nan_to_num(rows, nan=1.0), 0, 1), np.float32)
