"""Scene files, read by their format."""

from __future__ import annotations

import math
from pathlib import Path

from ..scene.model import Scene
from .trimesh_scenes import load_mesh_file


def load_scene(path: Path | str, *, crease: float = math.radians(40), up: str = "auto") -> Scene:
    """Read a mesh or scene file of any format that trimesh knows.

    crease: meshes without normals stay sharp at edges with a larger angle, radians; 0 shades flat. up: which axis of the file
    points upwards for automatic cameras, x, y, z or auto. Raises SceneError for files that cannot be read or drawn.
    """
    return load_mesh_file(path, crease=crease, up=up)
