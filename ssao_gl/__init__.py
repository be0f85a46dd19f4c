"""Screen-space ambient occlusion on OpenGL ES, headless or inside your own program.

Start with ``render`` (scenes), ``apply`` and ``occlusion`` (arrays), ``Effect`` (your GL program). The public names are
listed in ``__init__.pyi``; each is imported on first use, so that importing the package costs next to nothing.
"""

import sys
from types import ModuleType
from typing import Any

import lazy_loader

_public, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

_RENAMED = {"Draw": "Mesh"}
"""Names of 0.1 -> their names now. They go in 0.3."""


def __getattr__(name: str) -> Any:
    """Import a public name, or look up the version; warn of a name that was renamed."""
    if name == "__version__":
        import importlib.metadata

        return importlib.metadata.version("ssao_gl")  # which reads a file
    if name in _RENAMED:
        import warnings

        now = _RENAMED[name]
        warnings.warn(f"ssao_gl.{name} is called ssao_gl.{now} now; the old name goes in 0.3", DeprecationWarning, stacklevel=2)
        return _public(now)
    if name not in __all__ and not name.startswith("_"):
        from .errors import near_miss
        from .methods.registry import registry

        known = f" Methods go by name: ssao_gl.method('{name.lower()}')." if name.lower() in registry() else ""
        guess = known or near_miss(name, __all__)
        raise AttributeError(f"ssao_gl has no '{name}'.{guess}")
    return _public(name)


class _Package(ModuleType):
    """This package, whose ``render``, ``bake``, ``batch`` and ``export`` stay the functions when the rooms of these names are imported."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in ("render", "bake", "batch", "export") or not isinstance(value, ModuleType):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
