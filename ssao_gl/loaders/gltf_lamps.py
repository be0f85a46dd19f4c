"""Lamps of glTF files: KHR_lights_punctual."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import one_line
from ..scene.lamps import Lamp
from ..scene.projection import Matrix
from .gltf_document import Document, index

LIGHTS = "KHR_lights_punctual"
MAX_LAMPS = 1000


def lamps_of(document: Document, worlds: Mapping[int, Matrix]) -> list[Lamp]:
    """Return the lamps at their nodes; what is broken is noted and left out. ``worlds``: transform of each node to the world."""
    entries = document.tree.get("extensions", {}).get(LIGHTS, {}).get("lights", [])
    found: list[Lamp] = []
    for number, world in worlds.items():
        node = document.tree["nodes"][number]
        hangs = node.get("extensions", {}).get(LIGHTS)
        if hangs is None or len(found) == MAX_LAMPS:
            continue
        try:
            found.append(_lamp(entries[index(hangs["light"])], world, str(node.get("name") or "")))
        except Exception as error:  # the picture can be drawn without
            document.notes.add(f"a light of the file is unusable: {one_line(error)}")
    return found


def _lamp(entry: Mapping[str, Any], world: Matrix, name: str) -> Lamp:
    """Return a lamp where it stands. It shines along -z of its node, whose scale changes nothing. Raises SceneError."""
    spot = entry.get("spot", {})
    reach = entry.get("range")
    r, g, b = (float(value) * float(entry.get("intensity", 1.0)) for value in entry.get("color", (1.0, 1.0, 1.0)))
    cone = float(spot.get("innerConeAngle", 0.0)), float(spot.get("outerConeAngle", math.pi / 4))
    return Lamp.hung(entry["type"], np.asarray(world), (r, g, b), None if reach is None else float(reach), cone, name)
