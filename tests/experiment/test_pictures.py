"""Tests of ``experiment/pictures.py``."""

from __future__ import annotations

import numpy as np

from ssao_gl.experiment import pictures
from ssao_gl.metrics.zones import Zones


def test_error_colours_are_symmetric_about_white() -> None:
    dark, none, bright, nowhere = pictures.palette()[pictures.indices([-1.0, 0.0, 1.0, np.nan])]
    assert tuple(none) == (247, 247, 247) and dark[2] > dark[0] and bright[0] > bright[2] and tuple(nowhere) == pictures.NOWHERE
    assert pictures.reduced(np.ones((101, 961))).shape == (33, 320)


def test_zones_are_places_in_their_palette() -> None:
    edge, crease, seen = (np.zeros((6, 12), bool) for _ in range(3))
    edge[:, :2], crease[:, 2:4], seen[:, :8] = True, True, True
    zones = Zones(edge, crease, seen & ~edge & ~crease)
    assert (pictures.zone_indices(zones, 12)[0] == [0, 0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]).all()
    assert (pictures.zone_indices(zones, 6) == [0, 1, 2, 2, 3, 3]).all() and pictures.zone_indices(zones, 6).shape == (3, 6)
