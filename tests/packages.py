"""Packages that are tested against, and are part of no installation of ssao_gl."""

from __future__ import annotations

import importlib
import os
import warnings
from typing import Any

import pytest

EXPECTED = os.environ.get("SSAO_GL_EXPECT_PACKAGES", "").split(",")
"""Names of packages whose absence is a failure, by commas, as in CI."""


def needed(name: str) -> Any:
    """Import a package, or skip the test where it is not installed or does not load; fail where it is expected."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of others, while they are imported
            return importlib.import_module(name)
    except ImportError as reason:
        if name in EXPECTED:
            raise
        pytest.skip(f"{name} cannot be imported here ({reason})")
