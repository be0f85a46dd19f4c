"""How far visibility is from the truth, and one picture from another, in numbers.

:func:`measure` gives every metric of a visibility image; the others are in :mod:`.visibility` and :mod:`.images`.
"""

from .visibility import measure

__all__ = ["measure"]
