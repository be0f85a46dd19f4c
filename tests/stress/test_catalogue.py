"""Tests of ``stress/catalogue.py``."""

from __future__ import annotations

import ssao_gl as ao
from ssao_gl.stress.catalogue import cases


def test_contracts_that_methods_declare_are_asked_for() -> None:
    """A declared exception that no case looks at would be an excuse for nothing."""
    asked = {case.contract for case in cases().values()} | {kind for case in cases().values() for kind in case.asks}
    assert {contract for kind in ao.registry().values() for contract in kind.exceptions} <= asked  # type: ignore[attr-defined]
