"""Ambient occlusion that a file can keep: traced by rays, into vertex colours or occlusion textures of glTF, without OpenGL.

Start with :func:`~ssao_gl.bake.run.bake`. Needs the extra ``bake`` (embreex, scipy, xatlas).
"""

from .run import Baked, BakedMesh, bake
from .settings import Baking, OcclusionTexture, Vertices

__all__ = ["Baked", "BakedMesh", "Baking", "OcclusionTexture", "Vertices", "bake"]
