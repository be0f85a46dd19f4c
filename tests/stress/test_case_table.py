"""The stress battery without OpenGL: its table, its random cases, its verdicts, how it makes failures smaller."""

from __future__ import annotations

from pathlib import Path

import pytest

import ssao_gl as ao
from ssao_gl.cli import main
from ssao_gl.stress import case_table
from ssao_gl.stress.catalogue import cases

PAGE = Path(case_table.__file__).with_name("CASES.md")


def test_the_page_of_cases_is_up_to_date() -> None:
    """Write it with: ssao-gl stress --list --markdown > ssao_gl/stress/CASES.md"""
    assert PAGE.read_text("utf-8") == case_table.case_table_markdown()


def test_every_trap_has_a_case() -> None:
    assert len(case_table.TRAPS) == 45
    assert {trap for case in cases().values() for trap in case.traps} == set(range(1, 46))


@pytest.mark.parametrize("name", ["alchemy", "bitmask", "reference"])
def test_recommended_methods_break_nothing(name: str) -> None:
    assert dict(ao.registry()[name].exceptions) == {}  # type: ignore[attr-defined]


@pytest.mark.gl
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "plain"], "Did you mean 'plane'"),
        (["--only", "random-x"], "no such case"),
        (["--seed", "-1"], "must not be negative"),
        (["--cases", "-5"], "must not be negative"),
        (["-o", "results.txt"], "unknown suffix"),
        (["-o", "no/such/folder/r.json"], "there is no folder"),
        (["--replay", "nowhere"], "nowhere/case.json: no such file"),
        (["--methods", "alchemi"], "Did you mean 'alchemy'"),
        (["--gl", "egl-se"], "unknown provider"),
    ],
)
def test_bad_options_get_one_line(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["stress", *arguments])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and message in said and said.count("\n") == 1


@pytest.mark.gl
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("{", "not JSON"),
        ("[]", "expected an object"),
        ("{}", "not what ssao-gl stress writes"),
        ('{"method": "alchemy", "preset": "default", "settings": [], "whole": true, "case": "plane"}', "not what"),
        ('{"method": "alchemy", "preset": "default", "settings": {}, "whole": true, "case": "x"}', "not what"),
        ('{"method": "alchemy", "preset": "default", "settings": {}, "whole": false, "case": "x", "shots": [{}]}', "not what"),
    ],
)
def test_a_broken_folder_gets_one_line(text: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "case.json").write_text(text)
    with pytest.raises(SystemExit) as ended:
        main(["stress", "--replay", str(tmp_path)])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and message in said and said.count("\n") == 1


def test_the_list_needs_no_opengl(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["stress", "--list", "--markdown"])
    assert not ended.value.code and capsys.readouterr().out == case_table.case_table_markdown()
