"""The arithmetic of the report: fronts, fits, intervals, tables. No OpenGL, no rays."""

from __future__ import annotations

import pytest

from ssao_gl.errors import SettingsError
from ssao_gl.experiment import timing, variants
from ssao_gl.gl.timer import PassTime
from ssao_gl.report import markdown, tables


def test_rounds_are_interleaved_and_the_first_is_dropped() -> None:
    order: list[str] = []

    def draw(name: str) -> list[PassTime]:
        order.append(name)
        return [
            PassTime("gbuffer", 50, "wall", 1, "gbuffer"),
            PassTime("alchemy", len(order), "wall", 2, "occlusion"),
            PassTime("blur x", 1, "wall", 3, "denoise"),
        ]

    runs = timing.interleaved({"a": lambda: draw("a"), "b": lambda: draw("b")}, 2)
    assert order == ["a", "b", "b", "a", "a", "b"]
    found = timing.summary(runs["a"])
    assert found["method"]["wall"][1] == 4.5 and found["total"]["wall"][1] == 5.5 and found["total"]["cpu"][1] == 5
    assert found["gbuffer"]["wall"][1] == 50 and list(found["passes"]) == ["gbuffer", "alchemy", "blur x"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((["alchmy"],), "Did you mean 'alchemy'"),
        ((["alchemy"], ["drift"]), "Did you mean 'draft'"),
        ((["alchemy"], [], ["samples=3"]), "must be method.setting"),
        ((["alchemy"], [], ["lecture.samples=3"]), "no method 'lecture' in this report"),
        ((["alchemy"], [], ["alchemy.sample=3"]), "Did you mean 'samples'"),
    ],
)
def test_unknown_variants_say_what_there_is(arguments: tuple[list[str], ...], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        variants.variants(*arguments)


def test_markdown_grid_aligns_numbers_and_escapes() -> None:
    table = tables.Table("T", "", (tables.Column("name"), tables.Column("x", ".2f")), [["a|b", 1.234], ["c", None]])
    assert markdown.grid(table).splitlines() == ["| name | x |", "|---|---:|", "| a\\|b | 1.23 |", "| c | – |"]


def test_markdown_escapes_names() -> None:
    """Names of files and scenes stand in cells, in the list of facts and in the command: nothing in them is markup there."""
    name = "a*b* [x](y) <b> `c` _d_ ~~e~~ \\ |\n# f"
    table = tables.Table("T", "", (tables.Column("name"),), [[name]])
    plain = r"a\*b\* \[x\](y) &lt;b&gt; \`c\` \_d\_ \~\~e\~\~ \\ \| # f"
    assert markdown.grid(table).splitlines()[-1] == f"| {plain} |"
    machine = {
        "threads": {}, "provider": "p", "renderer": "r", "gl_version": "v", "cpu": "c", "cores": 2, "system": "s", "python": "3",
        "packages": {}, "commit": "", "software": True,
    }  # fmt: skip
    truth = {"falloff": "hard", "normals": "geometric", "spp": 1, "seed": 0}
    found = {
        "machine": machine, "settings": {"truth": truth, "rounds": 1}, "made": "today", "command": f"ssao-gl report '{name}'",
        "scenes": {"fit": [name], "test": []},
    }  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(markdown, "tables", lambda found: [])
        lines = markdown.markdown(found, []).splitlines()
    assert f"- fitted on: {plain}" in lines
    assert lines[2] == "`` ssao-gl report 'a*b* [x](y) <b> `c` _d_ ~~e~~ \\ | # f' ``"
