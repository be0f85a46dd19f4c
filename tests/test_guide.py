"""Every block of code on the pages of the guide is run, from top to bottom of its page, as a reader would."""

from __future__ import annotations

import re
import shlex
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from ssao_gl.cli.help_pages import COMMANDS

from .command_line import run
from .packages import needed

GUIDE = Path(__file__).parents[1] / "demos" / "guide"
OF_THEIR_OWN = {"README", "add_a_method"}
"""Pages without code, or with a test of their own: tests/methods/test_plugins.py."""
PAGES = sorted(path for path in GUIDE.glob("*.md") if path.stem not in OF_THEIR_OWN)
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
PACKAGES = {
    "tools": ("pyvista", "pyrender"),
    "cluster": ("distributed",),
    "compare_methods": ("embreex",),
    "bake": ("embreex", "xatlas"),
}
"""Packages that a page says it needs."""
SHOWN = ("python", "console", "sh")
"""Languages of blocks; sh is for other computers, and is not run."""


def blocks(page: Path) -> Iterator[tuple[str, str]]:
    for language, text in BLOCK.findall(page.read_text("utf-8")):
        assert language in SHOWN, f"{page.name}: a block of {language} is not run; use one of {', '.join(SHOWN)}"
        yield language, text


def commands(page: Path) -> set[str]:
    texts = [text for language, text in blocks(page) if language == "console"]
    return {command for text in texts for command in re.findall(r"^\$ ssao-gl (\w+)", text, re.M)}


@pytest.fixture
def readers_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the pages take for granted: some models, a camera file, colour and depth of a camera."""
    folder = tmp_path / "reader"
    (folder / "models").mkdir(parents=True)
    chair = trimesh.util.concatenate(
        [trimesh.creation.box((1, 0.2, 1)), trimesh.creation.box(bounds=((-0.5, 0, -0.5), (0.5, 1, -0.3)))]
    )
    chair.export(folder / "models" / "chair.glb")
    chair.export(folder / "model.glb")
    trimesh.creation.annulus(0.4, 0.5, 1).export(folder / "models" / "cup.stl")
    (folder / "model.cam.json").write_text(
        '{"cameras": [{"name": "front", "eye": [2, 2, 2], "target": [0, 0, 0], "yfov_deg": 40}]}'
    )
    depth = np.full((120, 160), 1500, np.uint16)
    depth[40:80, 60:100], depth[:4] = 1350, 0
    Image.fromarray(depth).save(folder / "depth.png")
    Image.fromarray(np.full((120, 160, 3), 200, np.uint8)).save(folder / "color.png")
    monkeypatch.chdir(folder)
    return folder


@pytest.mark.gl
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_page(page: Path, readers_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for package in PACKAGES.get(page.stem, ()):
        needed(package)
    names: dict[str, object] = {}
    for number, (language, text) in enumerate(blocks(page)):
        if language == "python":
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DeprecationWarning)  # of others
                exec(compile(text, f"{page.name}, block {number}", "exec"), names)
        if language == "console":
            for line in re.findall(r"^\$ ssao-gl (.*)$", text, re.M):
                code, _, err = run(*shlex.split(line), capsys=capsys)
                assert code == 0, (line, err)
    for name, thing in names.items():
        if name.startswith("test_"):
            thing()  # type: ignore[operator]
    made = [path for path in readers_folder.rglob("*.png") if path.name not in ("color.png", "depth.png")]
    assert made, "a page shows how to make something"
    for path in made:
        with Image.open(path) as image:
            assert (image.size >= (96, 54) and np.ptp(np.asarray(image.convert("L"))) > 10) or "difference" in path.name, (
                path.name
            )


def test_pages_are_listed_and_say_what_occlusion_is() -> None:
    listed = set(re.findall(r"\]\((\w+)\.md\)", (GUIDE / "README.md").read_text("utf-8")))
    assert listed == {path.stem for path in GUIDE.glob("*.md")} - {"README"}
    for page in PAGES:
        text = page.read_text("utf-8")
        about = text[: text.index("```")]
        assert re.search(r"ambient occlusion", about, re.I) and len(text) < 4000, page.name


def test_links_lead_somewhere() -> None:
    for page in GUIDE.glob("*.md"):
        for link in re.findall(r"\]\((?!http)([\w./-]+)\)", page.read_text("utf-8")):
            assert (page.parent / link).exists(), f"{page.name}: {link}"


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_commands_are_known(page: Path) -> None:
    assert commands(page) <= set(COMMANDS)


@pytest.mark.parametrize("page", ["contact_sheet", "dataset", "depth_camera", "image_tests", "bake"])
def test_a_task_is_one_or_two_commands(page: str) -> None:
    """Of strangers who came for a thumbnail, a data set, a RealSense frame, a gate in CI, a GLB for a game."""
    commands_of = [
        len(re.findall(r"^\$ ", text, re.M)) for language, text in blocks(GUIDE / f"{page}.md") if language == "console"
    ]
    assert commands_of[0] == 1 and max(commands_of) <= 2


def test_a_plot_of_pyvista_is_five_lines() -> None:
    (text,) = [text for _, text in blocks(GUIDE / "tools.md") if "import pyvista" in text]
    assert len([line for line in text.splitlines() if line.strip()]) <= 5
