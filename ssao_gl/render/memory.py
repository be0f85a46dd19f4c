"""How much memory there is to take: a software renderer that gets less than it asked for is killed, or crashes."""

from __future__ import annotations

from ..errors import ContextError
from ..io.memory import free_memory
from ..scene.projection import Size

READ_BACK = 32
"""Bytes a pixel of the arrays that come back, and of what is made on the way."""
DRIVER = 64 << 20
"""Bytes that a software renderer takes for itself while it draws."""


def check_room(targets: int, size: Size) -> None:
    """Raise ContextError when a frame of ``size`` whose targets take so many bytes does not fit into what is free."""
    need, have = targets + READ_BACK * size[0] * size[1] + DRIVER, free_memory()
    if need > have:
        raise ContextError(
            f"a frame of {size[0]}x{size[1]} takes {need / 2**20:.0f} MiB of memory, but {have / 2**20:.0f} MiB are free;"
            " draw a smaller one, or in tiles"
        )
