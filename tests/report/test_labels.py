"""Tests of ``report/labels.py``."""

from __future__ import annotations

import numpy as np

from ssao_gl.report import labels


def test_names_do_not_cover_each_other() -> None:
    at = np.array([[100.0, 100], [104, 101], [108, 99], [110, 104]])
    sizes = np.full((4, 2), (60.0, 12.0))
    corners = labels.place_labels(at, sizes, (0, 0, 300, 300), [np.array([[0.0, 100], [300, 100]])])
    boxes = np.concatenate([corners, corners + sizes], 1)
    assert (labels.overlap(boxes, boxes) - np.diag([720.0] * 4)).max() == 0
    assert corners.min() >= 0 and (corners + sizes).max() <= 300
