"""Hashes that tell whether results of earlier still hold."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..glsl import preprocess
from ..scene.model import Mesh
from ..scene.spheres import Spheres
from ..scene.volume import Volume

if TYPE_CHECKING:
    from hashlib import _Hash

PRESENTING = ("__main__.py", "__init__.py", "__init__.pyi", "cli", "report", "stress")
"""What no measurement goes through, at the top of the package: it tells of results, or asks questions of its own."""


@cache
def code_fingerprint() -> str:
    """Return the hash of the shaders and of all code that pictures and measurements go through.

    Results of another code are not mixed with those of this one, whatever version the package says it has.
    """
    return fingerprint_of(Path(__file__).resolve().parent.parent, preprocess.root())


def fingerprint_of(package: Path, shaders: Path) -> str:
    """Return the hash of a package's code and shaders: of their paths below their folders, and of their bytes."""
    code = [p for p in package.rglob("*.py") if p.relative_to(package).parts[0] not in PRESENTING]
    digest = hashlib.sha256()
    for root, files in ((package, code), (shaders, [p for p in shaders.rglob("*") if p.is_file()])):
        for path in sorted(files):
            content = path.read_bytes()
            digest.update(f"{path.relative_to(root).as_posix()}\0{len(content)}\0".encode())
            digest.update(content)
    return digest.hexdigest()[:32]


def add_arrays(digest: _Hash, arrays: Iterable[NDArray[Any] | None]) -> None:
    """Add arrays with their types and shapes: two must not pass for another two of the same bytes in a row."""
    for array in arrays:
        digest.update(repr(None if array is None else (array.dtype.str, array.shape)).encode())
        if array is not None:
            digest.update(np.ascontiguousarray(array).data)


def add_mesh(digest: _Hash, mesh: Mesh, *, normals: bool, colors: bool) -> None:
    """Add the triangles of a mesh and where they are, and what alpha cuts out of them.

    On demand what shades them, and what colours them.
    """
    add_arrays(digest, (mesh.positions, mesh.triangles, mesh.transforms, mesh.normals if normals else None))
    if colors:
        add_arrays(digest, (np.array(mesh.color), mesh.vertex_colors))
    if mesh.cutoff is not None and mesh.material is not None:
        digest.update(repr((mesh.cutoff, mesh.material.base_color[3])).encode())
        add_arrays(digest, (None if mesh.vertex_colors is None else mesh.vertex_colors[:, 3],))
    texture = mesh.texture
    if texture is not None and (colors or mesh.cutoff is not None):
        digest.update(repr((texture.wrap, texture.nearest, texture.mipmaps)).encode())
        add_arrays(digest, (mesh.uv, texture.array))


def add_thing(digest: _Hash, thing: Mesh | Spheres | Volume, *, normals: bool, colors: bool) -> None:
    """Add what a scene is made of: where it is, and on demand what shades and what colours it."""
    match thing:
        case Mesh():
            add_mesh(digest, thing, normals=normals, colors=colors)
        case Spheres():
            digest.update(b"spheres")
            add_arrays(digest, (thing.centers, thing.radii, thing.transforms))
            if colors:
                add_arrays(digest, (np.array(thing.color), thing.colors))
        case Volume():
            digest.update(repr(("volume", thing.iso)).encode())
            add_arrays(digest, (thing.array, thing.affine))
            if thing.transfer is not None:
                table = thing.transfer_of().table()
                digest.update(repr((thing.transfer.unit, thing.transfer.step)).encode())
                add_arrays(digest, (table if colors else np.ascontiguousarray(table[:, 3]),))
            elif colors:
                add_arrays(digest, (np.array(thing.color),))
