"""One lock for all that is written: of an open file, so that nothing is left beside it and the system drops it with the process.

(The package ``filelock`` locks a second file, which stays beside every output; so it does not serve here.)
"""

from __future__ import annotations

import sys
from pathlib import Path

from ..errors import FormatError

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl


class HeldError(FormatError):
    """Another run writes there now."""


def lock(handle: int, what: Path) -> bool:
    """Lock an open file for this process; the lock goes when the handle is closed. False where files cannot be locked.

    ``what``: the output that it stands for. Raises HeldError when another run holds it.
    """
    try:
        if sys.platform == "win32":
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):  # the second is Windows'
        raise HeldError(f"cannot write {what}: another run is writing there now; wait for it, or choose another name") from None
    except OSError:  # a file system without locks
        return False
    return True
