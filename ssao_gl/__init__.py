"""Screen-space ambient occlusion on OpenGL ES, headless or inside your own program.

Start with ``render`` (scenes), ``apply`` and ``occlusion`` (arrays), ``Effect`` (your GL program). The public names are
listed in ``__init__.pyi``; each is imported on first use, so that importing the package costs next to nothing.
"""

from typing import Any

import lazy_loader

_public, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

_RENAMED = {"Draw": "Mesh"}
"""Names of 0.1 -> their names now. They go in 0.3."""


def __getattr__(name: str) -> Any:
    """Import a public name; warn of one that was renamed."""
    if name in _RENAMED:
        import warnings

        now = _RENAMED[name]
        warnings.warn(f"ssao_gl.{name} is called ssao_gl.{now} now; the old name goes in 0.3", DeprecationWarning, stacklevel=2)
        return _public(now)
    return _public(name)
