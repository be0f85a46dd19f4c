"""The named cases. Importing this package fills the table; groups stand in the order of ``__all__``."""

from . import absent, cameras, formats, images, invariances, meshes, normals, radii, sizes, surfaces, texels

__all__ = [
    "surfaces",
    "formats",
    "cameras",
    "radii",
    "sizes",
    "texels",
    "normals",
    "meshes",
    "invariances",
    "images",
    "absent",
]
