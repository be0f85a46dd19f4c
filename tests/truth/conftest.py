"""Fixtures: the embedded scene, and what its camera sees."""

from __future__ import annotations

import pytest

from ssao_gl.scene.model import Scene
from ssao_gl.scene.sample_scene import default_scene
from ssao_gl.truth import Surface, surface

SIZE = (48, 36)


@pytest.fixture(scope="module")
def courtyard() -> Scene:
    return default_scene()


@pytest.fixture(scope="module")
def seen(courtyard: Scene) -> Surface:
    return surface(courtyard, courtyard.cameras[0], SIZE)
