"""One browser for all tests, and a process that draws with the browser's own renderer."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from ssao_gl.export.write import RUNTIME

from ..browser import draw_with_swiftshader, served_page, swiftshader

SERVED = {"ssao-gl.js": RUNTIME.read_text("utf-8"), "page.js": Path(__file__).with_name("page.js").read_text("utf-8")}


@pytest.fixture(scope="session")
def served() -> dict[str, str]:
    """Files of the page's origin; tests may add theirs."""
    return dict(SERVED)


@pytest.fixture(scope="session")
def page(served: dict[str, str], browser: Any) -> Iterator[object]:
    """A page with ``SsaoGl`` and the helpers of page.js on its window, and ``gl``, a WebGL2 context."""
    page = served_page(browser, served)
    page.evaluate("""async () => {
        Object.assign(window, await import("/ssao-gl.js"), await import("/page.js"));
        window.gl = context();
    }""")
    yield page
    page.close()


@pytest.fixture(scope="session")
def reference() -> Iterator[ProcessPoolExecutor]:
    """A process in which ANGLE draws with the renderer that the browser has."""
    driver = swiftshader()
    if driver is None:
        pytest.skip("this browser's SwiftShader is not a file that others could load")
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, spawn, initializer=draw_with_swiftshader, initargs=(str(driver),)) as pool:
        yield pool
