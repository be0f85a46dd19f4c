"""What the README says of exports, run as it stands there."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from ..browser import ORIGIN
from ..command_line import run
from .cases import Case
from .test_native import COMPILER, HEADERS, read_netpbm, write_pfm
from .test_write_webgl2 import decoded

README = Path(__file__).parents[2] / "README.md"
SECTION = README.read_text("utf-8").split("\n## Use it in your engine\n", 1)[1].split("\n## ", 1)[0]
CASE = Case("perspective", (64, 36), color=True)
HARNESS = """\
#define main program_main
#include "native/main.c"
#undef main
int main(void) {
    int width, height;
    double projection[16];
    float *depth = read_image("depth.pfm", "Pf", &width, &height, sizeof(float));
    if (!depth || open_context()) return 3;
    perspective(projection, 50, 0.1, 100, (double)width / height);
    GLuint depth_texture = upload(depth, GL_R32F, GL_RED, GL_FLOAT, width, height);
    BLOCK
    return visibility ? 0 : (puts(ssao_error()), 1);
}
"""


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", SECTION, re.DOTALL)


def commands(block: str) -> list[list[str]]:
    return [line.removeprefix("$ ").split() for line in block.splitlines()]


def test_the_section_has_the_blocks_that_are_run() -> None:
    assert [len(blocks(language)) for language in ("console", "js", "c")] == [2, 1, 1]


def test_the_web_page(page: Any, served: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    for words in commands(blocks("console")[0]):
        assert words[0] == "ssao-gl" and run(*words[1:], capsys=capsys)[0] == 0
    imports, code = blocks("js")[0].split("\n\n", 1)
    served |= {f"readme/ao/{path.name}": path.read_text("utf-8") for path in (tmp_path / "ao").iterdir()}
    served["readme/page.js"] = (
        f"{imports}\nexport default function (gl, width, height, depth, color, projection) {{\n{code}\nreturn ao; }}\n"
    )
    found = page.evaluate(
        """async ([job, url]) => {
            const { default: readme } = await import(url), gl = context(), given = inputs(gl, job);
            [gl.canvas.width, gl.canvas.height] = job.size;
            const ao = readme(gl, ...job.size, given.depth, given.color, job.projection);
            return [read(gl, null, job.size), ao.settings.radius];
        }""",
        [CASE.job(), f"{ORIGIN}readme/page.js"],
    )
    drawn = decoded(found[0], CASE.size)
    assert found[1] == 0.8
    dimmed = CASE.picture[..., :3].astype(int) - drawn[..., :3]
    assert dimmed.min() >= -2 and dimmed.max() > 10


@pytest.mark.gl
def test_the_native_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    if COMPILER is None or not HEADERS or shutil.which("cc") is None:
        pytest.skip("no C compiler, or no headers of EGL and GLES")
    monkeypatch.chdir(tmp_path)
    write_pfm(tmp_path / "depth.pfm", CASE.depth)
    for words in commands(blocks("console")[1]):
        if words[0] == "ssao-gl":
            assert run(*words[1:], capsys=capsys)[0] == 0
        else:
            subprocess.run(words, check=True, timeout=60)
    assert read_netpbm(tmp_path / "visibility.pgm").std() > 5
    (tmp_path / "block.c").write_text(HARNESS.replace("BLOCK", blocks("c")[0]))
    subprocess.run(
        ["cc", "-Inative", "block.c", "native/ssao.c", "-lEGL", "-lGLESv2", "-lm", "-o", "block"], check=True, timeout=60
    )
    subprocess.run(["./block"], check=True, timeout=60)
