"""Settings of the methods that add up what each element of a scene hides."""

from __future__ import annotations

from typing import Any

from ..settings import setting


def scale() -> Any:
    """Return the field ``scale: int``, in pixels."""
    return setting(2, "pixels along each side of a texel that occlusion is added up for", low=1, high=4)


def sums() -> Any:
    """Return the field ``sums: str``."""
    return setting(
        "float",
        "floats that sums are kept in: of 32 bits, or half of that for drivers that add up no others",
        choices=("float", "half"),
    )


def max_fill() -> Any:
    """Return the field ``max_fill: float``, in million fragments."""
    return setting(8000.0, "largest fill; a picture that needs more is refused", unit="million fragments", above=0)
