"""Animations of glTF at one moment: what they make of the nodes (glTF 2.0, 3.11 and appendix C)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError, near_miss
from .gltf_accessors import values
from .gltf_document import Document, Tree, index

Floats = NDArray[np.float64]
PATHS = ("translation", "rotation", "scale", "weights")


def pose(document: Document, name: str, time: float) -> None:
    """Set the nodes of a document's tree as its animation ``name`` (or number) has them at ``time``, seconds. Raises SceneError."""
    if not math.isfinite(time):
        raise SceneError(f"an animation has no time {time:g}; it must be a finite number of seconds")
    animation = _chosen(document.tree.get("animations", []), name)
    for channel in animation["channels"]:
        target = channel["target"]
        if "node" not in target:
            continue
        if target["path"] not in PATHS:
            document.notes.add(f"the animation's channel '{target['path']}' is not applied")
            continue
        node = document.entry("nodes", target["node"])
        node[target["path"]] = sample(document, animation["samplers"][index(channel["sampler"])], target["path"], time).tolist()


def _chosen(animations: list[Tree], name: str) -> Tree:
    if not animations:
        raise SceneError(f"has no animations; leave out the animation '{name}'")
    names = [str(entry.get("name", number)) for number, entry in enumerate(animations)]
    if name in names:
        return animations[names.index(name)]
    if name.isascii() and name.isdigit() and int(name[:9]) < len(animations):
        return animations[int(name)]
    listed = ", ".join(repr(known) for known in names[:8]) + (", ..." if len(names) > 8 else "")
    raise SceneError(f"has no animation '{name}'; there are {listed}.{near_miss(name, names)}")


def sample(document: Document, sampler: Tree, path: str, time: float) -> Floats:
    """The values of a channel at ``time``: before its first and after its last key it stays as it is there."""
    times = values(document, sampler["input"]).ravel().astype(np.float64)
    kind: Any = sampler.get("interpolation", "LINEAR")
    keys = values(document, sampler["output"]).astype(np.float64)
    if not len(times) or not len(keys):
        raise SceneError("has an animation without keys; it is broken")
    tangents = kind == "CUBICSPLINE"
    width = keys.size // (len(times) * (3 if tangents else 1))
    rows = keys.ravel()[: len(times) * (3 if tangents else 1) * width].reshape(len(times), -1, width)
    before = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(times) - 1))
    after = min(before + 1, len(times) - 1)
    span = times[after] - times[before]
    t = float(np.clip((time - times[before]) / span, 0, 1)) if span > 0 else 0.0
    if tangents:
        (_, p0, out), (into, p1, _) = rows[before], rows[after]
        found = (
            (2 * t**3 - 3 * t**2 + 1) * p0
            + span * (t**3 - 2 * t**2 + t) * out
            + (3 * t**2 - 2 * t**3) * p1
            + span * (t**3 - t**2) * into
        )
    elif kind == "STEP":
        found = rows[after if t == 1 else before, 0]
    elif path == "rotation":
        found = _slerp(rows[before, 0], rows[after, 0], t)
    else:
        found = (1 - t) * rows[before, 0] + t * rows[after, 0]
    found = np.asarray(found, np.float64)
    return found / (np.linalg.norm(found) or 1.0) if path == "rotation" else found


def _slerp(a: Floats, b: Floats, t: float) -> Floats:
    """From one unit quaternion to another, the short way round (Shoemake 1985)."""
    a, b = a / (np.linalg.norm(a) or 1.0), b / (np.linalg.norm(b) or 1.0)
    cosine = float(a @ b)
    if cosine < 0:
        b, cosine = -b, -cosine
    angle = math.acos(min(cosine, 1.0))
    if angle < 1e-6:
        return (1 - t) * a + t * b
    return (math.sin((1 - t) * angle) * a + math.sin(t * angle) * b) / math.sin(angle)
