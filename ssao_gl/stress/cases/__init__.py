"""The named cases. Importing this package fills the table; groups stand in the order of the imports."""

from . import absent, cameras, formats, images, invariances, meshes, normals, radii, sizes, surfaces, texels

__all__ = [
    "absent",
    "cameras",
    "formats",
    "images",
    "invariances",
    "meshes",
    "normals",
    "radii",
    "sizes",
    "surfaces",
    "texels",
]
