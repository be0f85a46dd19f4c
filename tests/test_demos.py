"""Every demo runs headless, in seconds, and leaves pictures of the right size with something on them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from .packages import EXPECTED

DEMOS = sorted((Path(__file__).parents[1] / "demos").glob("[0-9]*.py"))
SIZE = (96, 54)
EXCUSES = {"skipped: pyrender cannot be imported here": 0, "OffscreenRenderer skipped: pyrender's own OpenGL does not": 3}
"""What 04_pyrender.py says where pyrender's own OpenGL is missing, and how many pictures it makes all the same."""
MISSING = re.compile(r"skipped: (pyvista|open3d) cannot be imported here")
"""What demos say where a package is missing that no installation of ssao_gl brings."""
PICTURES = {
    "01_hello": 3, "02_numpy": 2, "03_trimesh": 2, "04_pyrender": 5, "08_molecule": 2, "09_volume": 2,
    "10_pyvista": 4, "15_elements": 3, "16_object_space": 6, "11_open3d": 2, "13_cameras": 3,
}  # fmt: skip


def test_the_demos_are_here() -> None:
    assert len(DEMOS) >= 7


@pytest.mark.gl
@pytest.mark.parametrize("demo", DEMOS, ids=lambda path: path.stem)
def test_demo(demo: Path, tmp_path: Path) -> None:
    command = [sys.executable, str(demo), "-o", str(tmp_path / "made"), "--size", "x".join(map(str, SIZE))]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=tmp_path, check=False)
    assert run.returncode == 0, run.stderr
    assert "Traceback" not in run.stderr
    missing = MISSING.match(run.stdout)
    if missing is not None and missing[1] not in EXPECTED:
        pytest.skip(f"{missing[1]} is not installed here")
    pictures = sorted((tmp_path / "made").glob("*.png"))
    expected = next((count for text, count in EXCUSES.items() if text in run.stdout), PICTURES.get(demo.stem, 1))
    assert len(pictures) == expected, run.stdout
    for path in pictures:
        with Image.open(path) as image:
            assert image.size == SIZE
            values = np.asarray(image.convert("L"))
        assert values.std() > 3 and len(np.unique(values)) > (2 if "segments" in path.name else 10), (
            f"{path.name} shows next to nothing"
        )
    for path in (tmp_path / "made").glob("*.webp"):
        with Image.open(path) as animation:
            assert animation.size == SIZE and animation.n_frames >= 12
    assert list(tmp_path.iterdir()) == [tmp_path / "made"], "a demo wrote outside its folder"
