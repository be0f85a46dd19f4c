"""Measure ssao_gl beside N8AO and three.js's own passes, in a headless browser: error against rays, and time.

Before: npm install in this folder. SCENE.glb takes the cameras of SCENE.cam.json beside it, or its own.
"""

import argparse
import functools
import http.server
import json
import math
import shutil
import statistics
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

import ssao_gl as ao
from ssao_gl.loaders.camera_files import load_cameras
from ssao_gl.truth.settings import Tracing
from ssao_gl.truth.trace import trace

HERE = Path(__file__).parent
PRESETS = ("draft", "medium", "high")
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync")  # fmt: skip


def prepared(site: Path, scenes: list[Path], only: set[str], size: tuple[int, int], spp: int, rounds: int) -> None:
    """Put everything that the page loads into a folder."""
    shutil.copytree(HERE, site, ignore=shutil.ignore_patterns("node_modules", "*.py", "*.png"))
    (site / "node_modules").symlink_to((HERE / "node_modules").resolve())
    data = site / "data"
    for quality in PRESETS:
        ao.export(data / quality, target="webgl2", method=ao.method("bitmask", quality, radius=1.0))
    ao.export(data / "three", target="three", method=ao.Bitmask(radius=1.0))
    views = []
    for path in scenes:
        scene = ao.load_scene(path)
        shutil.copy(path, data / path.name)
        table = json.loads(path.with_suffix(".cam.json").read_text("utf-8"))["cameras"]
        for entry, camera in zip(table, load_cameras(path.with_suffix(".cam.json"), size), strict=True):
            name = f"{path.stem}:{camera.name}"
            if only and name not in only:
                continue
            found = trace(scene, camera, size, Tracing(spp=spp))
            kept = np.where(found.depth > 0, found.visibility, -1)[::-1].astype("<f4")
            (data / f"{len(views)}.f32").write_bytes(kept.tobytes())
            reach = 1.01 * float(np.linalg.norm(camera.pose[:3, 3] - scene.bounds.mean(0))) + scene.extent / 2
            views.append(
                {**entry, "name": name, "scene": path.name, "truth": f"{len(views)}.f32", "spp": found.spp, "reach": reach}
            )
    job = {"size": size, "rounds": rounds, "presets": PRESETS, "views": views}
    (data / "job.json").write_text(json.dumps(job), "utf-8")


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        pass


@contextmanager
def served(folder: Path) -> Iterator[str]:
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}"
    server.shutdown()


def measured(url: str, picture: Path | None, chromium: str | None) -> dict[str, Any]:
    """Open the page, and return what it found."""
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.goto(f"{url}/compare.html")
        page.wait_for_function("globalThis.results", timeout=3_600_000)
        results = page.evaluate("results")
        if picture is not None:
            page.screenshot(path=picture, full_page=True)
        browser.close()
    if "error" in results:
        raise SystemExit(f"the page failed: {results['error']}")
    return dict(results)


def table(results: dict[str, Any]) -> str:
    """Return the means over the views as Markdown; times as multiples of ours at medium, by the geometric mean."""
    views = results["views"]
    lines = ["| | RMSE | bias | ms | x |", "|---|---:|---:|---:|---:|"]
    for name in views[0]["rows"]:
        rows = [view["rows"][name] for view in views]
        ratios = [view["rows"][name]["ms"] / view["rows"]["ssao_gl medium"]["ms"] for view in views]
        share = math.exp(statistics.fmean(math.log(max(ratio, 1e-3)) for ratio in ratios))
        rmse, bias, ms = (statistics.fmean(row[key] for row in rows) for key in ("rmse", "bias", "ms"))
        lines.append(f"| {name} | {rmse:.4f} | {bias:+.3f} | {ms:.1f} | {share:.2f} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+", type=Path, metavar="SCENE.glb")
    parser.add_argument("--view", action="append", default=[], metavar="SCENE:CAMERA", help="only these (default: all)")
    parser.add_argument("--size", default="1280x720", metavar="WxH")
    parser.add_argument("--spp", type=int, default=128, help="rays a pixel of the truth (default: 128)")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--site", type=Path, required=True, help="new folder for the page and what it loads; kept")
    parser.add_argument("--picture", type=Path, help="PNG of the page")
    parser.add_argument("--chromium", default=shutil.which("chromium"), help="the browser (default: chromium of the path)")
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    prepared(given.site, given.scenes, set(given.view), (width, height), given.spp, given.rounds)
    with served(given.site) as url:
        results = measured(url, given.picture, given.chromium)
    (given.site / "results.json").write_text(json.dumps(results, indent=1), "utf-8")
    print(results["renderer"])
    print(table(results))


if __name__ == "__main__":
    main()
