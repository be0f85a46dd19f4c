"""Hashes that tell whether results of earlier still hold."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from ..glsl import preprocess

PRESENTING = ("cli", "report")
"""Folders of the package that change no measurement."""


@cache
def code_fingerprint() -> str:
    """Hash of the shaders and of all code that measurements go through: rows of another code are not mixed in."""
    digest = hashlib.sha256()
    package = Path(__file__).resolve().parent.parent
    python = [path for path in package.rglob("*.py") if path.relative_to(package).parts[0] not in PRESENTING]
    for path in sorted([*python, *(path for path in preprocess.root().rglob("*") if path.is_file())]):
        digest.update(f"{path.name} {path.stat().st_size}".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
