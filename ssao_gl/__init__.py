"""Screen-space ambient occlusion on OpenGL ES, headless or inside your own program.

Start with ``render`` (scenes), ``apply`` and ``occlusion`` (arrays), ``Effect`` (your GL program). The public names are
listed in ``__init__.pyi``; each is imported on first use, so that importing the package costs next to nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
