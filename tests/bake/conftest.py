"""Fixtures: the validator of the Khronos Group, and baking with few rays."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

VALIDATE = """
const fs = require('fs'), validator = require('gltf-validator');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))
  .then(report => console.log(JSON.stringify(report.issues.messages.filter(m => m.severity === 0))));
"""


@pytest.fixture(scope="session")
def errors_of() -> Callable[[Path], list[str]]:
    """What the glTF validator finds wrong (npm package gltf-validator, found by NODE_PATH). Skips without it."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node, so no glTF validator")
    if subprocess.run([node, "-e", "require('gltf-validator')"], capture_output=True, check=False).returncode:
        pytest.skip("no npm package gltf-validator in NODE_PATH")

    def errors(path: Path) -> list[str]:
        ran = subprocess.run([node, "-e", VALIDATE, str(path)], capture_output=True, check=True, text=True)
        return [f"{entry['code']} {entry.get('pointer', '')}: {entry['message']}" for entry in json.loads(ran.stdout)]

    return errors
