"""Tests of ``io/json_values.py``."""

from __future__ import annotations

import math

import numpy as np

from ssao_gl.io.json_values import to_json


def test_plain_has_no_infinities() -> None:
    assert to_json({"a": (np.float32(1), math.inf, math.nan), 2: np.arange(2)}) == {"a": [1.0, None, None], "2": [0, 1]}
