"""``python -m ssao_gl`` is ``ssao-gl``."""

from .cli import main

main()
