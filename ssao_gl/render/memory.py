"""How much memory there is to take: a software renderer that gets less than it asked for is killed, or crashes."""

from __future__ import annotations

import math
import sys
from pathlib import Path

from ..errors import ContextError
from ..scene.projection import Size

if sys.platform != "win32":
    import resource

READ_BACK = 32
"""Bytes a pixel of the arrays that come back, and of what is made on the way."""
DRIVER = 64 << 20
"""Bytes that a software renderer takes for itself while it draws."""

GROUP = Path("/sys/fs/cgroup")


def check_room(targets: int, size: Size) -> None:
    """Raise ContextError when a frame of ``size`` whose targets take so many bytes does not fit into what is free."""
    need, have = targets + READ_BACK * size[0] * size[1] + DRIVER, free()
    if need > have:
        raise ContextError(
            f"a frame of {size[0]}x{size[1]} takes {need / 2**20:.0f} MiB of memory, but {have / 2**20:.0f} MiB are free;"
            " draw a smaller one, or in tiles"
        )


def free() -> float:
    """Bytes that this process may still take: of the machine, of its control group, of its own limit; inf where none says."""
    room = [math.inf]
    if sys.platform == "linux":
        room.append(1024 * _number(Path("/proc/meminfo"), "MemAvailable:"))
        room.append(_number(GROUP / "memory.max") - _number(GROUP / "memory.current", missing=0))
        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit != resource.RLIM_INFINITY:
            room.append(limit - 1024 * _number(Path("/proc/self/status"), "VmSize:", missing=0))
    return max(min(room), 0)


def _number(path: Path, name: str = "", missing: float = math.inf) -> float:
    """Return the number after ``name``, or at the start, of a file of the system's; ``missing`` when it is not there
    ('max')."""
    try:
        return float(path.read_text().partition(name)[2].split()[0] if name else path.read_text())
    except (OSError, ValueError, IndexError):
        return missing
