"""Tests of ``experiment/sweep.py``."""

from __future__ import annotations

from ssao_gl.experiment.sweep import split_size


def test_split_size_keeps_the_shape() -> None:
    assert split_size((1280, 720)) == (320, 180) and split_size((64, 36)) == (64, 36)
