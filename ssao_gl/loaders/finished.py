"""Scenes from what readers made, with the last checks."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..errors import SceneError
from ..scene.material import SOLID_FROM
from ..scene.model import Mesh, Scene
from .mesh_building import check_span
from .notes import Notes

FARTHEST = 1e30
"""Largest coordinate of a scene in the world."""

MAX_PIECES = 10**9
"""More, by instances of instances, would keep a software renderer busy for hours."""


def finished(scene: Scene, notes: Notes) -> Scene:
    """Return the scene, with what was noted. Raises SceneError for sizes that cannot be drawn."""
    meshes = scene.meshes
    check_span("the scene", scene.bounds)
    if float(np.abs(scene.bounds).max()) > FARTHEST:
        raise SceneError(f"lies {float(np.abs(scene.bounds).max()):g} units from the origin; at most {FARTHEST:g}: move it")
    if scene.pieces > MAX_PIECES:
        raise SceneError(f"draws {scene.contents}, instances counted each; at most {MAX_PIECES:,} are drawn")
    blended = sum(
        mesh.material is not None and mesh.material.alpha_mode == "BLEND" and mesh.alpha_range[0] < 1 for mesh in meshes
    )
    if blended:
        notes.add(
            f"{blended} of {len(meshes)} meshes are transparent (alpha is blended): drawn solid where alpha is at least"
            f" {SOLID_FROM:g}, and not at all elsewhere"
        )
    if not scene.drawn:
        notes.add("nothing can be seen: all of it is transparent")
    elif not any(not isinstance(thing, Mesh) or _has_area(thing) for thing in scene.drawn):
        notes.add("nothing can be seen: none of its triangles has an area")
    return dataclasses.replace(scene, warnings=notes.lines)


def _has_area(mesh: Mesh) -> bool:
    """Whether some triangle has three corners that are not on one line, and some instance does not make it flat."""
    for start in range(0, len(mesh.triangles), 1 << 16):
        corners = mesh.positions[mesh.triangles[start : start + (1 << 16)]].astype(np.float64)
        area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        if area.any():
            flattened = np.linalg.matrix_rank(mesh.transforms[:, :3, :3]) < 2
            return not bool(flattened.all())
    return False
