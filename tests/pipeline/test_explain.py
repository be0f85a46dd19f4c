"""What is said of leaving out without drawing anything: rules and their reasons, resources, memory; and the command."""

from __future__ import annotations

import dataclasses
import json

import pytest

import ssao_gl as ao
from ssao_gl.graph.declare import BYTES
from ssao_gl.graph.names import COLOR, DEPTH, NORMAL, SCENE_MASK, SHADING_NORMAL, VISIBILITY
from ssao_gl.pipeline.explain import plan_memory, resource_table, rule_statuses
from ssao_gl.pipeline.frame_setup import frame_setup
from ssao_gl.pipeline.settings import CULLING_RULES
from ssao_gl.tiling.layout import USUAL_LIMIT

from ..command_line import refused, run
from ..shapes import camera, corner

SIZE = (320, 180)


def why(settings: ao.Settings, aovs: tuple[str, ...] = ("image",)) -> dict[str, str]:
    made = frame_setup(corner(), camera(), SIZE, settings, USUAL_LIMIT)
    return {rule.name: rule.why for rule in rule_statuses(made, made.plan(aovs))}


def test_each_rule_is_in_force_or_says_why() -> None:
    fixed = ao.Settings(method=ao.Bitmask(radius=1.0))
    adaptive = ao.Settings(method=ao.Bitmask(radius=1.0, adaptive=True))
    assert why(fixed) == {"background": "", "open": why(fixed)["open"], "adaptive": why(fixed)["adaptive"]}
    assert "taps a pixel" in why(fixed)["open"] and "adaptive=true" in why(fixed)["adaptive"]
    assert why(adaptive)["adaptive"] == "" and "adaptive rule" in why(adaptive)["open"]
    assert why(dataclasses.replace(adaptive, keep=("adaptive",)))["adaptive"] == "switched off"
    assert set(why(dataclasses.replace(fixed, keep=tuple(CULLING_RULES))).values()) == {"switched off"}
    assert why(ao.Settings(method=ao.Alchemy(radius=1.0)))["adaptive"] == "alchemy cannot"
    assert set(why(fixed, ("depth",)).values()) == {"no occlusion is drawn"}


def test_every_pass_and_resource_is_kept_or_left_out() -> None:
    settings = ao.Settings(method=ao.Bitmask(radius=1.0))
    plan = frame_setup(corner(), camera(), SIZE, settings, USUAL_LIMIT).plan(("visibility",))
    kept = {row["name"] for row in resource_table(plan)}
    assert kept == set(plan.where) and not kept & set(plan.culled)
    assert {"layer behind", "composite", COLOR, SHADING_NORMAL} <= set(plan.culled)
    for row in resource_table(plan):
        assert row["bytes"] == BYTES[row["format"]] * row["size"][0] * row["size"][1]


def test_memory_adds_up() -> None:
    settings = ao.Settings(method=ao.Bitmask(radius=1.0))
    plan = frame_setup(corner(), camera(), SIZE, settings, USUAL_LIMIT).plan(("visibility",))
    found = plan_memory(settings, SIZE, plan)
    w, h = plan.frame
    assert found.total == plan.bytes and found.shared == plan.unaliased_bytes - plan.bytes > 0
    assert found.culled[COLOR] == 4 * w * h and found.culled["layer behind"] == (4 + 4) * w * h
    own = {DEPTH, NORMAL, SCENE_MASK, VISIBILITY}
    assert found.beyond == plan.bytes - sum(plan.slots[plan.where[name]].bytes for name in own)
    deep, flat = (ao.Settings(method=ao.Bitmask(radius=1.0, scale=1, layers=layers)) for layers in (2, 1))
    assert plan_memory(deep, SIZE, plan).effect == plan_memory(flat, SIZE, plan).effect is not None


def test_the_default_takes_little_memory() -> None:
    """At 1280x720 at most 12 MiB beyond the caller's own buffers."""
    settings = ao.Settings(method=ao.Bitmask(radius=1.0))
    size = 1280, 720
    found = plan_memory(settings, size, frame_setup(corner(), camera(), size, settings, USUAL_LIMIT).plan(("image",)))
    assert found.effect is not None and max(found.beyond, found.effect) <= 12 * 2**20


def test_the_command_tells_it(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run("explain", capsys=capsys)
    for words in (
        "rule background: ",
        "rule open: ",
        "not in force: ",
        "guard: 32 pixels",
        "footprint: ",
        "memory: ",
        "saved: ",
    ):
        assert words in out, words
    _, out, _ = run("explain", "--json", capsys=capsys)
    found = json.loads(out)
    assert found["measured"] is None and found["memory"]["total"] == found["bytes"]
    assert found["drawn"]["size"] == [1344, 784]  # what is really drawn: the guard counts
    assert [rule["name"] for rule in found["rules"]] == list(CULLING_RULES) and found["rules"][0]["in_force"]
    assert {row["name"]: row.get("reason") for row in found["resources"] if not row["kept"]} == found["left_out"]


def test_bad_input_of_measuring(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--rounds 0" in refused(capsys, "explain", "--measure", "--rounds", 0)
    assert "--measure: a picture in tiles" in refused(capsys, "explain", "--measure", "--size", "640x360", "--tile", 64)
