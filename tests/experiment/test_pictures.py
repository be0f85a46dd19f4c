"""Tests of ``experiment/pictures.py``."""

from __future__ import annotations

import numpy as np

from ssao_gl.experiment import pictures


def test_error_colours_are_symmetric_about_white() -> None:
    dark, none, bright, nowhere = pictures.palette()[pictures.indices([-1.0, 0.0, 1.0, np.nan])]
    assert tuple(none) == (247, 247, 247) and dark[2] > dark[0] and bright[0] > bright[2] and tuple(nowhere) == pictures.NOWHERE
    assert pictures.reduced(np.ones((101, 961))).shape == (33, 320)
