"""Three little scenes, and what one process makes of them."""

from __future__ import annotations

from pathlib import Path

import pytest

import ssao_gl as ao

from .models import COUNT, content, pyramid


@pytest.fixture(scope="session")
def three_scenes(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("scenes")
    return [pyramid(folder / f"{name}.obj", height) for name, height in (("a", 0.5), ("b", 3.0), ("c", 1.0))]


@pytest.fixture(scope="session")
def expected(three_scenes: list[Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    output = tmp_path_factory.mktemp("whole") / "out"
    assert not ao.batch(three_scenes, output, cameras=f"orbit:{COUNT}", size=(64, 48), aovs="visibility,depth").failed
    return content(output)
