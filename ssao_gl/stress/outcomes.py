"""What bounds are made of, and how a case says that it has nothing to measure."""

STEP = 1 / 255 + 1e-6
"""One step of 8-bit visibility."""


class NotApplicable(Exception):
    """A case has nothing to measure here; the text says why."""
