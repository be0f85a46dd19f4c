"""Many pictures: scenes times cameras, drawn by several processes or by a cluster; what is done is not done again."""

from .request import Request
from .results import Results
from .run import batch

__all__ = ["Request", "Results", "batch"]
