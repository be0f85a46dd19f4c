"""Python's share of a frame: what it costs to ask for the draws, without the draws."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

import moderngl


@contextmanager
def without_draws() -> Iterator[None]:
    """Within the block vertex arrays draw nothing; binding, uniforms and state are done as ever."""
    with patch.object(moderngl.VertexArray, "render", lambda *_, **__: None):
        yield
