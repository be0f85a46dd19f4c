"""Textures of base colour and of baked visibility on the GPU: each picture once, with the wrapping and filtering that its material asks for."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..scene.material import ColorTexture, Wrap
from ..scene.mipmaps import smaller_copies
from .loader import Functions
from .programs import GpuResources

GL_SRGB8_ALPHA8, GL_RGBA8 = 0x8C43, 0x8058
GL_MAG_FILTER, GL_MIN_FILTER, GL_WRAP_S, GL_WRAP_T, GL_MAX_ANISOTROPY = 0x2800, 0x2801, 0x2802, 0x2803, 0x84FE
GL_NEAREST, GL_LINEAR, GL_LINEAR_MIPMAP_LINEAR = 0x2600, 0x2601, 0x2703
GL_WRAP: dict[Wrap, int] = {"repeat": 0x2901, "mirror": 0x8370, "clamp": 0x812F}

ANISOTROPY = 8.0
"""Most samples along the longer side of a pixel's footprint, on GPUs.

Mesa's software renderer blurs by it what is seen texel by texel, and takes half as long again.
"""
CHUNK = 1 << 22
"""Texels converted at a time."""

_Sampling = tuple[tuple[Wrap, Wrap], bool, bool]


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A texture with the name of its sampler."""

    texture: moderngl.Texture
    sampler: int
    _functions: Functions

    def bind(self, unit: int) -> None:
        """Bind both to a unit."""
        self.texture.use(unit)
        self._functions("glBindSampler", None, ctypes.c_uint, ctypes.c_uint)(unit, self.sampler)


class SceneTextures:
    """The textures of a scene. Texels are decoded from sRGB, but for those that are numbers, before they are blended; row 0 of a picture is v = 0."""

    def __init__(self, resources: GpuResources) -> None:
        self._ctx = resources.ctx
        self._textures: dict[int, tuple[ColorTexture, moderngl.Texture]] = {}
        self._samplers: dict[_Sampling, int] = {}

    def sampled(self, texture: ColorTexture) -> Sampled:
        """Return a texture, uploaded the first time, and the sampler for it."""
        if id(texture) not in self._textures:
            self._textures[id(texture)] = (texture, self._upload(texture))
        sampling = (texture.wrap, texture.nearest, texture.mipmaps)
        if sampling not in self._samplers:
            self._samplers[sampling] = self._sampler(*sampling)
        return Sampled(self._textures[id(texture)][1], self._samplers[sampling], self._ctx.functions)

    def _upload(self, texture: ColorTexture) -> moderngl.Texture:
        texels = _fitting(texture.array, self._ctx.max_size)
        h, w = texels.shape[:2]
        # With alpha whatever the picture has: OpenGL ES makes mipmaps of sRGB textures of four channels only.
        made = self._ctx.mgl.texture((w, h), 4, internal_format=GL_RGBA8 if texture.linear else GL_SRGB8_ALPHA8)
        _write(made, texels, 0)
        if texture.mipmaps:
            made.build_mipmaps()
            if not texture.linear and ((w & (w - 1)) or (h & (h - 1))):
                # Drivers halve powers of two well; of other sizes Mesa's reads some texels and leaves others out.
                for level, copy in enumerate(smaller_copies(texels), 1):
                    _write(made, copy, level)
        return made

    def _sampler(self, wrap: tuple[Wrap, Wrap], nearest: bool, mipmaps: bool) -> int:
        """Make a sampler by OpenGL's own functions: moderngl knows no mirrored repetition."""
        gl, name = self._ctx.functions, ctypes.c_uint()
        gl("glGenSamplers", None, ctypes.c_int, ctypes.c_void_p)(1, ctypes.addressof(name))
        most = GL_NEAREST if nearest else GL_LINEAR
        values = {
            GL_MAG_FILTER: most, GL_MIN_FILTER: GL_LINEAR_MIPMAP_LINEAR if mipmaps else most,
            GL_WRAP_S: GL_WRAP[wrap[0]], GL_WRAP_T: GL_WRAP[wrap[1]],
        }  # fmt: skip
        for key, value in values.items():
            gl("glSamplerParameteri", None, ctypes.c_uint, ctypes.c_uint, ctypes.c_int)(name.value, key, value)
        if mipmaps and not self._ctx.software and (most_there := self._ctx.mgl.max_anisotropy) > 1:
            anisotropy = gl("glSamplerParameterf", None, ctypes.c_uint, ctypes.c_uint, ctypes.c_float)
            anisotropy(name.value, GL_MAX_ANISOTROPY, min(ANISOTROPY, most_there))
        return name.value

    def release(self) -> None:
        """Free every texture and sampler."""
        for _, texture in self._textures.values():
            texture.release()
        delete = self._ctx.functions("glDeleteSamplers", None, ctypes.c_int, ctypes.c_void_p)
        for sampler in self._samplers.values():
            delete(1, ctypes.byref(ctypes.c_uint(sampler)))
        self._textures, self._samplers = {}, {}


def _write(texture: moderngl.Texture, texels: NDArray[np.uint8], level: int) -> None:
    """Fill a level, some rows at a time."""
    h, w = texels.shape[:2]
    rows = max(CHUNK // w, 1)
    for top in range(0, h, rows):
        part = texels[top : top + rows]
        four = np.full((*part.shape[:2], 4), 255, np.uint8)
        four[..., : part.shape[2]] = part
        texture.write(four, viewport=(0, top, w, len(part)), level=level)


def _fitting(texels: NDArray[np.uint8], largest: int) -> NDArray[np.uint8]:
    """Return texels of at most ``largest`` rows and columns: every n-th of a picture that is larger."""
    step = -(-max(texels.shape[:2]) // largest)
    return texels[::step, ::step]
