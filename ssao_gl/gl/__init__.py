"""OpenGL: the only part of ssao_gl, with ``passes`` and ``effect``, that calls it."""

from .context import Context
from .providers import PROVIDERS, Provider, wrap_current, wrap_moderngl
from .providers import open_context as open

__all__ = ["PROVIDERS", "Context", "Provider", "open", "wrap_current", "wrap_moderngl"]
