"""sRGB against its definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.errors import FormatError
from ssao_gl.io.srgb import multiply
from ssao_gl.scene.srgb import decode, encode, encoded_rgb


@given(st.floats(0, 1))
def test_decoding_undoes_encoding(value: float) -> None:
    assert decode(encode(value)) == pytest.approx(value, abs=1e-7)


def test_values_of_the_standard() -> None:
    assert encode([0.0, 0.0031308, 0.214041, 1.0, 2.0, -1.0]) == pytest.approx([0, 0.04045, 0.5, 1, 1, 0], abs=1e-4)
    assert encoded_rgb((0.0, 0.214041, 1.0)) == pytest.approx((0, 0.5, 1), abs=1e-5)


def test_colour_is_dimmed_in_linear_light() -> None:
    color = np.array([[[188, 255, 0, 7]]], np.uint8)
    assert multiply(color, [[1.0]]).tolist() == color.tolist()
    assert multiply(color, [[0.5]]).tolist() == [[[137, 188, 0, 7]]]
    with pytest.raises(FormatError, match="do not fit"):
        multiply(color, [1.0])
