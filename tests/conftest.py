"""Fixtures: a renderer for every OpenGL provider that opens here, and scenes to try things on."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

import ssao_gl as ao
from ssao_gl.gl.providers import PROVIDERS
from ssao_gl.scene.sample_scene import default_scene

EXPECTED = [name for name in os.environ.get("SSAO_GL_EXPECT", "").split(",") if name]
"""Providers whose absence is a failure."""


# The same examples in every run, so that a change is judged by itself; HYPOTHESIS_PROFILE=default looks for new ones.
settings.register_profile("same", derandomize=True, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))


@cache
def openable() -> tuple[str, ...]:
    names = []
    for provider in PROVIDERS.values():
        try:
            provider.open().release()
            names.append(provider.name)
        except Exception as reason:
            if provider.name in EXPECTED:
                pytest.exit(f"provider {provider.name} is expected here but does not open: {reason}", 1)
    return tuple(names)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A headless Chromium, driven by playwright."""
    from .browser import CHROMIUM, WHY_NONE, launched

    if CHROMIUM is None:
        pytest.skip(WHY_NONE)
    with launched() as browser:
        yield browser


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate", action="store_true", help="rewrite tests/images/references from what is drawn now")


def pytest_report_header() -> str:
    return f"OpenGL providers: {', '.join(openable()) or 'none'}"


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Refuse to pass without OpenGL, unless tests that need it are left out on purpose: ``-m "not gl"``."""
    if not openable() and any(item.get_closest_marker("gl") for item in items):
        pytest.exit('no OpenGL provider opens here (see: ssao-gl doctor); -m "not gl" leaves out what needs one', 1)


def pytest_itemcollected(item: pytest.Item) -> None:
    if {"provider", "renderer", "any_renderer"} & set(getattr(item, "fixturenames", ())):
        item.add_marker("gl")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "provider" in metafunc.fixturenames:
        metafunc.parametrize("provider", openable(), scope="module")


@pytest.fixture(scope="module")
def renderer(provider: str) -> Iterator[ao.Renderer]:
    with ao.Renderer(provider) as made:
        yield made


@pytest.fixture(scope="module")
def any_renderer() -> Iterator[ao.Renderer]:
    """One renderer, the first that opens: for what does not depend on the driver."""
    with ao.Renderer(openable()[0]) as made:
        yield made


@pytest.fixture(scope="session")
def embedded() -> ao.Scene:
    return default_scene()


def real_scenes() -> list[Path]:
    """Scene files with cameras beside them in the folder that SSAO_GL_SCENES names; none by default."""
    folder = os.environ.get("SSAO_GL_SCENES")
    if not folder:
        return []
    return [path for path in sorted(Path(folder).glob("*.glb")) if path.with_suffix(".cam.json").exists()]
