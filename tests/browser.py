"""A headless Chromium, and the renderer that it draws with, for Python."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, Route, sync_playwright

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
WHY_NONE = "no Chromium is installed: apt-get install chromium"
FLAGS = (
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
ORIGIN = "http://page.test/"
TYPES = {".js": "text/javascript", ".html": "text/html", ".json": "application/json"}


def swiftshader() -> Path | None:
    """The browser's own software renderer, as a Vulkan driver that ANGLE in Python draws with, too."""
    if CHROMIUM is None:
        return None
    folders = [Path(CHROMIUM).resolve().parent, Path("/usr/lib/chromium"), Path("/usr/lib/chromium-browser")]
    return next(
        (folder / "vk_swiftshader_icd.json" for folder in folders if (folder / "vk_swiftshader_icd.json").exists()), None
    )


def draw_with_swiftshader(driver: str) -> None:
    """Let ANGLE open that Vulkan driver; before it is loaded."""
    os.environ["VK_ICD_FILENAMES"] = os.environ["VK_DRIVER_FILES"] = driver


@contextmanager
def launched() -> Iterator[Browser]:
    """Give a headless browser."""
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, headless=True, args=list(FLAGS))
        yield browser
        browser.close()


def served_page(browser: Browser, files: Mapping[str, str]) -> Page:
    """Return an empty page of an origin that holds ``files`` (name -> text), and nothing of the network."""
    page = browser.new_page()
    page.route("**/*", lambda route: _serve(route, files))
    page.goto(ORIGIN)
    return page


def _serve(route: Route, files: Mapping[str, str]) -> None:
    name = route.request.url.removeprefix(ORIGIN).split("?")[0] or "index.html"
    text = files.get(name, "<!doctype html><title>test</title>" if name == "index.html" else None)
    if text is None:
        route.fulfill(status=404)
    else:
        route.fulfill(body=text, content_type=TYPES[Path(name).suffix])
