"""Ray-traced ambient occlusion of the very points that the G-buffer shows: what screen-space methods are measured by.

Start with :func:`trace`; :mod:`.closed_forms` has scenes whose occlusion is known without rays. Needs the extra
``truth`` (embreex, scipy); nothing of it is imported before it is used.
"""

from .settings import Tracing
from .surface import Surface, surface
from .trace import Truth, gather, trace

__all__ = ["Surface", "Tracing", "Truth", "gather", "surface", "trace"]
