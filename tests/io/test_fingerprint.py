"""What changes a fingerprint, and what does not."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.glsl import preprocess
from ssao_gl.io.fingerprint import add_arrays, add_mesh, code_fingerprint, fingerprint_of

PACKAGE = Path(ao.__file__).parent


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    shutil.copytree(PACKAGE, tmp_path / "ssao_gl", ignore=shutil.ignore_patterns("__pycache__", "*cache"))
    shutil.copytree(preprocess.root(), tmp_path / "shaders")
    return tmp_path


def of(folder: Path) -> str:
    return fingerprint_of(folder / "ssao_gl", folder / "shaders")


def edited(path: Path) -> None:
    path.write_text(path.read_text() + "\n# edited\n")


MEASURING = ["experiment/error_split.py", "experiment/timing.py", "experiment/measure.py", "truth/rays.py", "metrics/visibility.py",
    "planner/cost_model.py", "gl/executor.py", "methods/bitmask.py", "io/journal.py"]  # fmt: skip
PRESENTING = ["report/page.py", "report/tables.py", "cli/report.py", "stress/case_table.py", "__main__.py"]


def test_it_is_that_of_the_code_at_work(copy: Path) -> None:
    assert of(copy) == code_fingerprint() == of(copy)


@pytest.mark.parametrize("name", MEASURING)
def test_editing_what_measures_changes_it(copy: Path, name: str) -> None:
    edited(copy / "ssao_gl" / name)
    assert of(copy) != code_fingerprint()


@pytest.mark.parametrize("name", PRESENTING)
def test_editing_what_presents_does_not(copy: Path, name: str) -> None:
    edited(copy / "ssao_gl" / name)
    assert of(copy) == code_fingerprint()


def test_shaders_and_places_count(copy: Path) -> None:
    edited(copy / "shaders" / "lib" / "slice.glsl")
    changed = of(copy)
    assert changed != code_fingerprint()
    (copy / "ssao_gl" / "methods" / "sao.py").rename(copy / "ssao_gl" / "passes" / "sao.py")
    assert of(copy) != changed, "a file counts with its folder"


def test_arrays_count_with_their_types_and_shapes() -> None:
    def of_arrays(*arrays: np.ndarray | None) -> str:
        digest = hashlib.sha256()
        add_arrays(digest, arrays)
        return digest.hexdigest()

    zeros = np.zeros(4, np.float32)
    different = [
        (zeros,),
        (zeros.reshape(2, 2),),
        (zeros.view(np.int32),),
        (zeros, None),
        (None, zeros),
        (zeros[:2], zeros[2:]),
    ]
    assert len({of_arrays(*arrays) for arrays in different}) == len(different)


def test_a_mesh_counts_with_what_is_asked_for() -> None:
    def of_mesh(mesh: ao.Mesh, **asked: bool) -> str:
        digest = hashlib.sha256()
        add_mesh(digest, mesh, **asked)
        return digest.hexdigest()

    points, triangles = np.eye(3, dtype=np.float32), np.arange(3, dtype=np.uint32)[None]
    bare, red = ao.Mesh(points, triangles), ao.Mesh(points, triangles, color=(1.0, 0.0, 0.0))
    smooth = ao.Mesh(points, triangles, normals=points)
    assert of_mesh(bare, normals=False, colors=False) == of_mesh(red, normals=False, colors=False)
    assert of_mesh(bare, normals=False, colors=True) != of_mesh(red, normals=False, colors=True)
    assert of_mesh(bare, normals=True, colors=False) != of_mesh(smooth, normals=True, colors=False)
    assert of_mesh(bare, normals=False, colors=False) == of_mesh(smooth, normals=False, colors=False)
