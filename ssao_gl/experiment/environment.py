"""What a report was made with: driver, versions, cores, commit. And what of the package its numbers depend on."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import subprocess
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from ..errors import SettingsError
from ..gl.context import Context

PACKAGES = ("ssao_gl", "numpy", "moderngl", "embreex", "scipy", "scikit-image", "flip-evaluator", "matplotlib", "trimesh")
NEEDED = {
    "embreex": "embreex",
    "scipy": "scipy",
    "scikit-image": "skimage",
    "flip-evaluator": "flip_evaluator",
    "matplotlib": "matplotlib",
}
"""Package -> the module it is imported as."""

THREADS = ("LP_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def machine(ctx: Context) -> dict[str, Any]:
    """Everything that times may depend on."""
    return {
        "provider": ctx.provider,
        "platform": ctx.platform,
        "renderer": ctx.renderer,
        "gl_version": ctx.version,
        "software": ctx.software,
        "cpu": _cpu(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "threads": {name: os.environ[name] for name in THREADS if name in os.environ},
        "system": platform.platform(),
        "python": platform.python_version(),
        "packages": {name: version for name in PACKAGES if (version := _version(name))},
        "commit": commit(),
    }


def check_packages() -> None:
    """Raise SettingsError, before hours of work, when a package is missing that is needed at its end."""
    missing = [name for name, module in NEEDED.items() if importlib.util.find_spec(module) is None]
    if missing:
        raise SettingsError(f"a report needs the packages {', '.join(missing)}: pip install 'ssao_gl[report]'")


def now() -> str:
    """Date and time, UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


@cache
def commit() -> str | None:
    """Commit of the checkout that this package runs from, with ``+`` when files differ from it; None outside of one."""
    folder = Path(__file__).resolve().parent
    try:
        tracked = _git(folder, "ls-files", "--error-unmatch", "__init__.py")
        return (
            _git(folder, "rev-parse", "--short=12", "HEAD") + ("+" if _git(folder, "status", "--porcelain") else "")
            if tracked
            else None
        )
    except (OSError, subprocess.SubprocessError):
        return None


def _git(folder: Path, *words: str) -> str:
    ran = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True, timeout=20)
    return ran.stdout.strip()


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
