"""The named cases. Importing this package fills the table; groups stand in the order of ``__all__``."""

from . import (
    absent,
    cameras,
    formats,
    images,
    invariances,
    meshes,
    normals,
    odd_scenes,
    radii,
    sizes,
    spheres,
    surfaces,
    texels,
    volumes,
)

__all__ = [
    "surfaces",
    "formats",
    "cameras",
    "radii",
    "sizes",
    "texels",
    "normals",
    "meshes",
    "odd_scenes",
    "spheres",
    "volumes",
    "invariances",
    "images",
    "absent",
]
