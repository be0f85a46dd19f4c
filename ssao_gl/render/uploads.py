"""Arrays of the caller's as textures, for as long as a frame needs them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import moderngl
from numpy.typing import NDArray

from ..gl.programs import GpuResources


@contextmanager
def uploaded(resources: GpuResources, arrays: Mapping[str, NDArray[Any]]) -> Iterator[dict[str, moderngl.Texture]]:
    """Yield arrays as textures by name, for as long as the block lasts."""
    inputs: dict[str, moderngl.Texture] = {}
    try:
        for name, array in arrays.items():
            inputs[name] = resources.upload(array)
        yield inputs
    finally:
        for texture in inputs.values():
            texture.release()
