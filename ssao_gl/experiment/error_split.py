"""Where the error comes from: the model, its sampling, the filter.

model: RMSE of the exhaustive screen-space reference against rays: what a depth buffer does not hold, and no number of
taps will mend. sampling: of the unfiltered picture against the reference. filter: of the filtered picture against the
unfiltered one without its noise. The three are no sum: parts of them cancel.
"""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np

from ..methods.reference import Reference
from ..pipeline.settings import Settings
from ..scene.camera import Camera
from ..scene.lens import Projection
from ..scene.projection import Size
from .view_setup import F32, ViewSetup

TILE = 4
"""Width of the tile of noise that is averaged away, pixels: that of every method here. Of wider ones a part remains."""


def reference_visibility(setup: ViewSetup) -> F32:
    """Visibility of the exhaustive reference, unfiltered."""
    return setup.draw(Settings(method=Reference(), blur=None))


def split_error(setup: ViewSetup, screen: F32, settings: Settings) -> dict[str, Any]:
    """Return the parts for a method; ``screen`` is the reference's picture. estimator: sampling without its noise."""
    bare = dataclasses.replace(settings, blur=None)
    raw, expected, final = setup.draw(bare), without_noise(setup, bare), setup.draw(settings)
    truth = setup.truth.visibility
    return {
        "model": setup.rmse(screen, truth),
        "sampling": setup.rmse(raw, screen),
        "estimator": setup.rmse(expected, screen),
        "filter": setup.rmse(final, expected),
        "raw": setup.rmse(raw, truth),
        "final": setup.rmse(final, truth),
    }


def without_noise(setup: ViewSetup, settings: Settings) -> F32:
    """Return the mean over all phases of the noise tile, at every pixel.

    The image is drawn moved by 0 to 3 whole pixels along x and y, by the projection, and moved back: each pixel shows
    the same point under each of the tile's 16 patterns. At the rim there are fewer.
    """
    w, h = setup.size
    total, count = np.zeros((h, w)), np.zeros((h, w))
    for dx, dy in itertools.product(range(min(TILE, w)), range(min(TILE, h))):
        moved = dataclasses.replace(setup, camera=shifted(setup.camera, setup.size, dx, dy), progress=None)
        drawn = moved.renderer.render(
            moved.scene, moved.camera, moved.size, setup.settled(settings), aovs=("visibility",), visibility_bits=8
        ).visibility
        total[dy:, : w - dx] += drawn[: h - dy, dx:]
        count[dy:, : w - dx] += 1
    return (total / count).astype(np.float32)


def shifted(camera: Camera, size: Size, dx: int, dy: int) -> Camera:
    """Return the camera with its image moved ``dx`` pixels to the right and ``dy`` up: clip x and y gain a share of clip w."""
    matrix = camera.lens.matrix(size).copy()
    matrix[0] += 2 * dx / size[0] * matrix[3]
    matrix[1] += 2 * dy / size[1] * matrix[3]
    return dataclasses.replace(camera, lens=Projection(matrix))
