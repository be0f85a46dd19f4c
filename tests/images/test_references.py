"""Pictures of every method, filter and the default pipeline against reference PNGs, on every provider.

On the renderer that made the reference (its name is in the file) every value must agree within 1/255. Other renderers
place the edges of triangles a little differently: there 99 % of the values must agree within 2/255, and SSIM be 0.99.
After a change that is meant: pytest tests/images --regenerate, look at the pictures, and say why in the commit.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import ssao_gl as ao
from ssao_gl.io import images
from ssao_gl.methods.registry import general
from ssao_gl.metrics.images import compare, difference_picture
from ssao_gl.passes.denoise import FILTERS
from ssao_gl.scene.model import Scene

REFERENCES = Path(__file__).parent / "references"
FAILURES = Path(__file__).parent.parent / "_out"
SIZE = (320, 180)

CHANGED = {
    "reference": {"slices": 8},
    "sao": {"intensity": 0.5},
    "gtao": {"power": 1.0},
    "bitmask": {"scale": 1, "slices": 8},
    "vom": {"scale": 2},
    "field": {"cones": 16},
}
"""field by many cones, of which one that falls into the next voxel on another renderer is a small part. vom at half size, where a pixel on the edge of a triangle decides for 2x2 and not for 4x4. bitmask at full size and by enough
slices that a sector is 1/255; the case ``default`` shows it at half. For a method that takes minutes on the slower software renderers as it is, and for two of such contrast that what renderers
differ by at the edges of triangles (1.0 % of the values by more than 2/255) would be all that the picture tests."""


def method(name: str) -> Any:
    return dataclasses.replace(ao.method(name), **CHANGED.get(name, {}))


CASES: dict[str, tuple[ao.Settings, str]] = {
    "default": (ao.Settings(), "image"),
    **{f"method-{name}": (ao.Settings(method=method(name)), "visibility") for name in general()},
    **{f"raw-{name}": (ao.Settings(method=method(name), blur=None), "visibility") for name in general()},
    **{f"blur-{name}": (ao.Settings(method=ao.Alchemy(), blur=kind()), "visibility") for name, kind in FILTERS.items()},
}


@pytest.mark.parametrize("case", CASES)
def test_picture(renderer: ao.Renderer, embedded: Scene, case: str, request: pytest.FixtureRequest) -> None:
    settings, aov = CASES[case]
    picture = renderer.render(embedded, None, SIZE, settings, aovs=(aov,), checked=True)
    actual, path = picture.as_png(aov), REFERENCES / f"{case}.png"
    if request.config.getoption("--regenerate"):
        regenerate(path, actual, renderer.ctx.renderer)
        return
    assert path.exists(), f"there is no reference {path}; make it with: pytest tests/images --regenerate"
    with Image.open(path) as reference:
        expected, made_by = np.asarray(reference), reference.info.get("renderer")
    difference = compare(actual, expected, ("ssim",))
    delta = np.abs(actual.astype(int) - expected)
    same = made_by == renderer.ctx.renderer
    good = difference.max_abs <= 1 if same else (delta <= 2).mean() >= 0.99 and difference.metrics["ssim"] >= 0.99
    if not good:
        FAILURES.mkdir(exist_ok=True)
        out = FAILURES / f"{case}-{renderer.ctx.provider}.png"
        images.save_image(out, difference_picture(actual, expected))
        pytest.fail(
            f"{case} on {renderer.ctx.provider} ({renderer.ctx.renderer}; reference by {made_by}): {difference.describe()}\n"
            f"actual | expected | difference x 16: {out}\nif the change is meant: pytest tests/images --regenerate"
        )


def regenerate(path: Path, actual: np.ndarray, renderer: str) -> None:
    """Rewrite a reference from the first provider that draws it; the others are compared on the next run."""
    if path.exists():
        with Image.open(path) as old:
            if old.info.get("renderer") != renderer and np.asarray(old).shape == actual.shape:
                return  # another renderer's turn
            change = compare(actual, np.asarray(old)).describe() if np.asarray(old).shape == actual.shape else "another size"
    else:
        change = "new"
    print(f"{path.name}: {change}")
    images.save_image(path, actual, texts={"renderer": renderer})


def test_references_are_small_and_all_in_use() -> None:
    files = {path.stem: path.stat().st_size for path in REFERENCES.glob("*.png")}
    assert set(files) == set(CASES)
    assert max(files.values()) < 60_000
