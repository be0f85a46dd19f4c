"""How far visibility is from the truth, and one picture from another, in numbers.

:func:`measure` gives every metric of a visibility image, in all of a view and in each of its zones (:func:`zones_of`); the
others are in :mod:`.visibility` and :mod:`.images`.
"""

from .visibility import measure
from .zones import Zones, zones_of

__all__ = ["Zones", "measure", "zones_of"]
