"""The whole command, small: everything is written, a second start measures nothing, the gate tells better from worse."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest

from ssao_gl.cli import main
from ssao_gl.experiment.culling_rules import subjects
from ssao_gl.experiment.run import Run
from ssao_gl.metrics.zones import ZONES

pytest.importorskip("embreex")
pytest.importorskip("matplotlib")
pytest.importorskip("flip_evaluator")

SMALL = [
    "--size",
    "64x36",
    "--spp",
    "4",
    "--rounds",
    "1",
    "--methods",
    "alchemy,lecture",
    "--presets",
    "low,4",
    "--reference-size",
    "32x18",
]


def report(folder: Path, *more: str) -> int:
    with pytest.raises(SystemExit) as left:
        main(["-q", "report", "-o", str(folder), "--cache", str(folder / "truth"), *SMALL, *more])
    return int(left.value.code or 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("report")
    assert report(made, "--latex") == 0
    return made


def test_all_files_are_there_and_tell_the_same(folder: Path) -> None:
    results = json.loads((folder / "results.json").read_text())
    (at,) = results["sizes"]
    labels = [point["label"] for point in at["shipped"]]
    assert labels == ["alchemy low", "lecture 4", "rays 1", "rays 2", "rays 4", "rays 8"]
    assert any(point["front"] for point in at["shipped"]) and at["baseline_ms"] > 0
    assert {row["variant"] for row in results["rows"]["split"]} == {"alchemy low", "lecture 4"}
    assert {"renderer", "gl_version", "cores", "packages", "commit"} <= set(results["machine"])
    with (folder / "results.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [line["track"] for line in lines] == ["as shipped"] * 6 + ["fitted"] * 2
    for label in labels:
        assert label in (folder / "report.md").read_text()
    for name in ("front-64x36", "front-cpu-64x36", "fitted-64x36", "zones-64x36", "passes-64x36", "split"):
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG") and "<svg" in (folder / f"{name}.svg").read_text()


def test_measurements_are_a_line_each(folder: Path) -> None:
    """The tidy table holds what the wide one does, and no line without a value."""
    with (folder / "results.csv").open() as file:
        wide = {(line["track"], line["variant"]): line for line in csv.DictReader(file)}
    with (folder / "measurements.csv").open() as file:
        lines = list(csv.DictReader(file))
    keys = [tuple(line[name] for name in list(line)[:-1]) for line in lines]
    assert len(set(keys)) == len(keys) and all(line["value"] for line in lines)
    for line in lines:
        row = wide[line["track"], line["variant"]]
        assert (line["scene"], line["width"]) == (row["scene"], row["width"])
        if line["quantity"] == "error":
            assert line["value"] == row[line["part"]]
        if line["quantity"] == "time" and line["statistic"] == "median" and not line["part"].startswith("pass "):
            assert line["value"] == row[line["part"] + {"wall": "_ms", "cpu": "_cpu_ms"}[line["clock"]]]
    found = {(line["quantity"], line["unit"]) for line in lines}
    assert found == {
        ("error", ""),
        ("error", "dB"),
        ("time", "ms"),
        ("baseline", "ms"),
        ("prepared", "ms"),
        ("prepared", "bytes"),
    }
    errors = sum(
        bool(row[key]) for row in wide.values() for key in ("rmse", "bias", "p95", "p99", "max", "psnr", "ssim", "flip")
    )
    assert sum(line["part"] in ("rmse", "bias", "p95", "p99", "max", "psnr", "ssim", "flip") for line in lines) == errors


def test_tables_for_papers(folder: Path) -> None:
    """Environments match, rows have a cell for each column, and nothing is left that LaTeX takes for markup."""
    text = (folder / "report.tex").read_text()
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == text.count(r"\toprule") >= 5
    for align, body in re.findall(r"\\begin{tabular}{([lr]+)}(.*?)\\end{tabular}", text, re.DOTALL):
        rows = [line for line in body.splitlines() if line.endswith(r"\\")]
        assert rows and all(len(re.findall(r"(?<!\\)&", row)) == len(align) - 1 for row in rows)
    assert not re.search(r"(?<!\\)[#_]|[×≤●–]", re.sub(r"^%.*$", "", text, flags=re.MULTILINE))


def test_errors_are_sound(folder: Path) -> None:
    at = json.loads((folder / "results.json").read_text())["sizes"][0]
    error = {point["label"]: point["errors"]["rmse"] for point in [*at["shipped"], *at["constants"]]}
    assert error["rays 8"] < error["rays 1"] < error["constant 1"]
    assert error["alchemy low"] < error["constant mean"]
    fitted = {point["label"]: point["errors"]["rmse"] for point in at["fitted_held_out"]}
    assert fitted["alchemy low"] <= error["alchemy low"] + 1e-3  # one scene: it is fitted where it is measured


def test_where_the_error_is(folder: Path) -> None:
    """In every file: zones of each estimator in each view, and the order of presets."""
    results = json.loads((folder / "results.json").read_text())
    (view,) = results["rows"]["view"]
    assert sum(view["zones"].values()) == pytest.approx(1) and view["zones"]["edge"] > 0
    for row in [*results["rows"]["estimate"], *results["rows"]["fitted"]]:
        errors = row["errors"]
        assert sum(errors[f"share_{zone}"] for zone in ZONES) == pytest.approx(1)
        assert errors["rmse_net"] <= errors["rmse"] and errors["rmse_flat_net"] <= errors["rmse_flat"] < errors["rmse_edge"]
        squares = sum(view["zones"][zone] * errors[f"rmse_{zone}"] ** 2 for zone in ZONES)
        assert squares == pytest.approx(errors["rmse"] ** 2)
    order = {one["variant"]: one for one in results["sizes"][0]["preset_order"]}
    assert order["rays 8"]["cheaper"].startswith("rays") and order["rays 8"]["share"] < 0
    with (folder / "results.csv").open() as file:
        lines = {line["variant"]: line for line in csv.DictReader(file) if line["track"] == "as shipped"}
    assert float(lines["rays 8"]["over_cheaper"]) == order["rays 8"]["share"] and not lines["alchemy low"]["over_cheaper"]
    assert float(lines["rays 8"]["rmse_edge_net"]) >= 0
    for name in ("report.md", "report.html", "report.tex"):
        text = (folder / name).read_text()
        for title in ("Where the error is, 64x36", "Presets in order, 64x36", "Where the error is, by view"):
            assert title in text, (name, title)
    assert 'alt="zones"' in (folder / "report.html").read_text()


def test_what_is_prepared_stands_apart_from_frames(folder: Path) -> None:
    """Rays keep a tree of the scene; methods of the screen keep nothing of it."""
    points = json.loads((folder / "results.json").read_text())["sizes"][0]["shipped"]
    for point in points:
        prepared = point["prepared"]
        assert (prepared["ms"] > 0 and prepared["bytes"] > 0) == (not point["realtime"]), point["label"]
    with (folder / "results.csv").open() as file:
        lines = {line["variant"]: line for line in csv.DictReader(file) if line["track"] == "as shipped"}
    assert float(lines["rays 1"]["prepared_ms"]) > 0 and float(lines["alchemy low"]["prepared_bytes"]) == 0
    assert "prepared ms" in (folder / "report.md").read_text()


def test_rules_are_shown_on_and_off(folder: Path) -> None:
    """Where there are few views, without being asked for."""
    results = json.loads((folder / "results.json").read_text())
    (row,) = results["rows"]["rules"]
    assert {one["label"] for one in row["rules"]} == set(subjects())
    assert {one["rule"] for one in row["rules"]} >= {"background", "adaptive", "all"}
    for one in row["rules"]:
        assert 0 < one["pixels"] <= 1 and one["on"] > 0 and one["off"] > 0
        assert one["bound"] is None or one["difference"] <= one["bound"] == 0
    assert (
        "## What was left out" in (folder / "report.md").read_text()
        and "What was left out" in (folder / "report.html").read_text()
    )


def test_the_page_needs_nothing_else(folder: Path) -> None:
    page = (folder / "report.html").read_text()
    assert not re.search(r'(?:src|href)="(?!data:|#)', page) and "url(" not in re.sub(r"url\(#[\w-]+\)", "", page)
    assert not re.search(r"@\w+@", page) and page.count("<svg") == 6
    assert page.count('class="pictures trio"') == 4 and "upper bound of what fitting gives" in page


def test_a_second_start_measures_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = (folder / "journal.jsonl").read_bytes()
    monkeypatch.setattr(Run, "_step", lambda self, step, setup: pytest.fail(f"measured {step.title} again"))
    assert report(folder) == 0
    assert (folder / "journal.jsonl").read_bytes() == before


def test_the_gate(folder: Path, tmp_path: Path) -> None:
    results = json.loads((folder / "results.json").read_text())
    for row in results["rows"]["estimate"]:
        row["errors"]["rmse"] *= 1.1
    worse = tmp_path / "worse.json"
    worse.write_text(json.dumps(results))
    codes = []
    for old, new in ((folder / "results.json", worse), (worse, folder / "results.json")):
        with pytest.raises(SystemExit) as left:
            main(["-q", "report", "--compare", str(old), str(new)])
        codes.append(left.value.code)
    assert codes == [1, 0]


def test_the_gate_of_single_views(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    results = json.loads((folder / "results.json").read_text())
    results["rows"]["estimate"][0]["errors"]["rmse"] *= 1.015
    worse = tmp_path / "worse.json"
    worse.write_text(json.dumps(results))
    codes = []
    for more in ([], ["--max-view-regression", "0.01"], ["--max-view-regression", "0.02"]):
        with pytest.raises(SystemExit) as left:
            main(["report", "--compare", str(folder / "results.json"), str(worse), *more])
        codes.append(left.value.code)
    said = " ".join(capsys.readouterr().out.split())
    assert codes == [0, 1, 0] and "RMSE is better in 0 of 6 pairs of view and variant, worse in 1; the other 5" in said


def test_results_of_another_format_are_refused(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = tmp_path / "old.json"
    old.write_text(json.dumps({**json.loads((folder / "results.json").read_text()), "format": "ssao_gl report 1"}))
    with pytest.raises(SystemExit) as left:
        main(["report", "--compare", str(old), str(folder / "results.json")])
    assert left.value.code == 2 and "'format' is not 'ssao_gl report 2'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.glb"], "no such file"),
        (["depth.npy"], "and needs a scene"),
        (["--compare", "missing.json"], "no such file"),
        (["--rounds", "0"], "at least 1"),
        (["--fit", "nothing"], "no such scene"),
        (["--cameras", "nobody"], "no scene has it"),
        (["-o", "/dev/null/x"], "cannot write"),
    ],
)
def test_bad_input_is_one_line(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["report", *arguments])
    said = capsys.readouterr().err
    assert left.value.code == 2 and message in said and said.count("\n") == 1
