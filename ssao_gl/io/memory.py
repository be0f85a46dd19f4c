"""How much memory this process may still take."""

from __future__ import annotations

import math
import sys
from pathlib import Path

if sys.platform != "win32":
    import resource

GROUP = Path("/sys/fs/cgroup")


def free_memory() -> float:
    """Return the bytes that this process may still take: of the machine, of its control group, of its own limit; inf where none says."""
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
