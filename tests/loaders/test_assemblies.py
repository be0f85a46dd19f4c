"""Biological assemblies: the grammar of their operators, and what they make."""

from __future__ import annotations

import numpy as np
import pytest

from ssao_gl.errors import SceneError
from ssao_gl.loaders.assemblies import Copies, operator_groups

TURN = np.array([[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
SHIFT = np.array([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


@pytest.mark.parametrize(
    ("expression", "groups"),
    [
        ("1", (("1",),)),
        ("1,2,5", (("1", "2", "5"),)),
        ("(1-3)", (("1", "2", "3"),)),
        ("(X0)(1-2,P)", (("X0",), ("1", "2", "P"))),
        ("P", (("P",),)),
        (" ( 1 , 7 - 8 ) ( P ) ", (("1", "7", "8"), ("P",))),
    ],
)
def test_grammar(expression: str, groups: tuple[tuple[str, ...], ...]) -> None:
    assert operator_groups(expression) == groups


@pytest.mark.parametrize("expression", ["", "()", "(1", "1)", "(5-1)", "(A-C)", "((1)(2))", "1,,2", "(1-999999999)"])
def test_what_is_no_expression(expression: str) -> None:
    with pytest.raises(SceneError, match="operators"):
        operator_groups(expression)


def test_the_right_operator_acts_first() -> None:
    copies = Copies(np.array([b"A"]), True, (("t",), ("s",)), {"t": TURN, "s": SHIFT})
    np.testing.assert_allclose(copies.transforms()[0] @ [0, 0, 0, 1], [1, 5, 0, 1])


def test_rounded_operators_are_made_rigid_and_others_refused() -> None:
    rounded = np.round(TURN + 1e-4, 3)
    (made,) = Copies(np.array([b"A"]), True, (("t",),), {"t": rounded}).transforms()
    np.testing.assert_allclose(made[:3, :3].T @ made[:3, :3], np.eye(3), atol=1e-12)
    for bad, told in (
        (2 * TURN, "lengths by 1 to 2|lengths by 2 to 2"),
        (np.zeros((4, 4)), "by 0 to 0"),
        (TURN * np.nan, "no numbers"),
    ):
        with pytest.raises(SceneError, match=f"operator 't' .*({told})"):
            Copies(np.array([b"A"]), True, (("t",),), {"t": bad}).transforms()
    with pytest.raises(SceneError, match="operator 'u', which the file does not have"):
        Copies(np.array([b"A"]), True, (("u",),), {}).transforms()
