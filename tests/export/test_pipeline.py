"""Pipelines as data: the schema holds, formulas give what Python's executor sets, settings stay open where they may."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import jsonschema
import numpy as np
import pytest

import ssao_gl as ao
from ssao_gl.errors import GraphError
from ssao_gl.export.formulas import VIEW_FORMULAS, formula
from ssao_gl.export.frames import LARGEST, scaled_size, sized_plan
from ssao_gl.export.pipeline import PipelineInputs, pipeline
from ssao_gl.export.write import SCHEMA, slim
from ssao_gl.gl.view_values import target_constants, view_value
from ssao_gl.graph.draws import Fullscreen, ViewValue
from ssao_gl.graph.plan import PlannedPass
from ssao_gl.passes.denoise import FILTERS
from ssao_gl.scene.projection import Size, ViewConstants

from .cases import CAMERAS, settings

VALIDATOR = jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text("utf-8")))
METHODS = [name for name, kind in ao.registry().items() if not kind().traits.needs_scene or kind().traits.single_layer]
ODD = [(1, 1), (161, 91), (17, 300)]


def cheap(name: str) -> ao.Settings:
    """The method with few taps, where its own are many to write out."""
    chosen = settings(name)
    return dataclasses.replace(chosen, method=chosen.method.traits.affordable or chosen.method)


def test_the_schema_is_one_and_knows_every_view_value() -> None:
    jsonschema.Draft202012Validator.check_schema(VALIDATOR.schema)
    assert VALIDATOR.schema["$defs"]["view"]["properties"]["view"]["enum"] == list(VIEW_FORMULAS)


@pytest.mark.parametrize("name", METHODS)
def test_every_method_is_exported_in_every_form(name: str) -> None:
    chosen = cheap(name)
    for given in (PipelineInputs(), PipelineInputs("eye", normals=True, color=True)):
        made = pipeline(dataclasses.replace(chosen, precision="mobile" if given.color else "high"), given)
        for form in (made, slim(made)):
            VALIDATOR.validate(json.loads(json.dumps(form, allow_nan=False)))
        assert set(made["inputs"]) == {"depth", *(["normals", "color"] if given.color else [])}
        assert made["output"]["resource"] == ("image" if given.color else "visibility")
        assert made["left_out"].get("encode normals", "") == ("" if given.normals else made["left_out"]["encode normals"])


@pytest.mark.parametrize("blur", [None, *FILTERS])
def test_every_filter_and_halos_are_exported(blur: str | None) -> None:
    shading = ao.Shading(halo=0.5)
    made = pipeline(dataclasses.replace(settings("alchemy"), blur=blur, shading=shading), PipelineInputs(color=True))
    VALIDATOR.validate(made)
    assert sum(step["role"] == "denoise" for step in made["steps"]) == {None: 0, "lecture": 1}.get(blur, 2)
    assert made["steps"][-1]["name"] == "halo"


BROKEN: dict[str, Any] = {
    "another format": lambda p: p.update(format="ssao_gl pipeline 2"),
    "a part that nobody knows": lambda p: p.update(more=1),
    "a step without a shader": lambda p: p["steps"][0].pop("shader"),
    "an unknown view value": lambda p: p["standard"].update(u_texel={"view": "texel"}),
    "an unknown texture format": lambda p: p["slots"][0].update(format="rgb9"),
    "no steps": lambda p: p.update(steps=[]),
}


@pytest.mark.parametrize("name", BROKEN)
def test_the_schema_refuses(name: str) -> None:
    made = json.loads(json.dumps(pipeline(settings("alchemy"), PipelineInputs())))
    BROKEN[name](made)
    assert not VALIDATOR.is_valid(made)


def evaluated(value: Any, view: ViewConstants, step: PlannedPass, made: dict[str, Any]) -> list[float]:
    """Return the numbers of a formula as its documentation says, from Python's constants of a view."""
    if isinstance(value, int | float):
        return [value]
    if isinstance(value, list):
        return [number for part in value for number in evaluated(part, view, step, made)]
    if "setting" in value:
        found = value.get("factor", 1.0) * np.ravel(made["live"][value["setting"]]["value"])[value.get("part", 0)]
        return [1 / found if value.get("inverse") else found]
    (factor,) = evaluated(value.get("factor", 1.0), view, step, made)
    names = {"clip_w": "u_w"}
    resource = made["resources"].get(value.get("resource"))
    size = (1, 1) if resource is None else scaled_size(made["slots"][resource]["scale"], view.size)
    if value["view"] in ("ray", "ray0", "org", "org0", "clip_w", "uv_per_unit"):
        numbers = view.constants[names.get(value["view"], f"u_{value['view']}")]
    else:
        numbers = view_value(ViewValue(value["view"]), view, step, lambda _: size)
    every = np.atleast_1d(np.asarray(numbers, float)) * factor
    every = 1 / every if value.get("inverse") else every
    return [x if value.get("axis", i) == i else 0.0 for i, x in enumerate(every)]


def executed(step: PlannedPass, view: ViewConstants, sizes: dict[str, Size]) -> dict[str, list[float]]:
    """Return what Python's executor gives a pass's uniforms."""
    draw = step.task.draw
    assert isinstance(draw, Fullscreen)
    own = {
        name: view_value(value, view, step, sizes.__getitem__) if isinstance(value, ViewValue) else value
        for name, value in draw.uniforms.items()
    }
    flat = {name: getattr(value, "array", lambda value=value: value)() for name, value in own.items()}
    return {
        name: np.ravel(np.asarray(value, float)).tolist()
        for name, value in {**view.constants, **target_constants(view, step), **flat}.items()
    }


@pytest.mark.parametrize("size", ODD, ids=lambda size: "x".join(map(str, size)))
@pytest.mark.parametrize("name", METHODS)
def test_formulas_give_what_the_executor_sets(name: str, size: Size) -> None:
    chosen, given = cheap(name), PipelineInputs(color=True)
    made = pipeline(chosen, given)
    plan = given.plan(chosen, size)
    by_name = {step["name"]: step for step in made["steps"]}
    when = {step["name"]: step.get("when", [1, 1]) for step in made["steps"]}
    runs = [name for name, least in when.items() if any(n and side >= n for n, side in zip(least, size, strict=True))]
    assert runs == [step.task.name for step in plan.steps]
    sizes = {name: plan.slots[slot].size for name, slot in plan.where.items()}
    for camera in CAMERAS.values():
        if name in ("lecture",) and camera is not CAMERAS["perspective"]:
            continue
        view = camera.view(size)
        for step in plan.steps:
            exported = by_name[step.task.name]
            assert scaled_size(exported["scale"], size) == step.size
            expected = executed(step, view, sizes)
            for uniform, value in {**made["standard"], **exported["uniforms"]}.items():
                found = evaluated(value, view, step, made)
                assert np.allclose(found, expected[uniform], rtol=1e-6, atol=0), (step.task.name, uniform)


def test_what_only_python_knows_is_refused() -> None:
    with pytest.raises(GraphError, match="pixel_smaller"):
        formula(ViewValue("pixel_smaller"), {})


def test_a_plan_that_depends_on_the_size_without_a_formula_is_refused() -> None:
    """Here the number of taps follows the width."""

    def plan_at(size: Size) -> Any:
        method = ao.Alchemy(radius=1.0, samples=4 if size[0] < LARGEST else 5)
        return PipelineInputs().plan(ao.Settings(method=method), size)

    with pytest.raises(GraphError, match="no formula"):
        sized_plan(plan_at)


LIVE = {
    "bitmask": {"radius", "strength", "power", "tint", "thickness", "tolerance"},
    "alchemy": {"radius", "strength", "power", "tint", "tolerance", "intensity", "bias"},
    "gtao": {"radius", "strength", "power", "tint", "tolerance"},
    "lecture": {"radius", "strength", "power", "tint", "tolerance"},
}


@pytest.mark.parametrize("name", LIVE)
def test_settings_that_change_numbers_alone_stay_open(name: str) -> None:
    made = pipeline(settings(name), PipelineInputs(color=True))
    assert set(made["live"]) == LIVE[name]
    assert all(made["fixed"].values())
    assert not set(made["fixed"]) & set(made["live"])


def test_a_live_setting_is_what_python_would_export() -> None:
    """Putting another value into an export's formulas gives the numbers of the export of that value."""
    base = settings("gtao")
    other = dataclasses.replace(base, method=dataclasses.replace(base.method, radius=0.37), blur=ao.Joint(tolerance=0.8))
    one, two = (pipeline(chosen, PipelineInputs()) for chosen in (base, other))
    for name in ("radius", "tolerance"):
        one["live"][name]["value"] = two["live"][name]["value"]
    assert {key: one[key] for key in one if key != "settings"} == {key: two[key] for key in two if key != "settings"}


def test_a_setting_that_is_no_proportion_is_fixed_and_says_why() -> None:
    made = pipeline(settings("hbao"), PipelineInputs())
    assert "u_bias" in made["fixed"]["bias"]
    assert made["fixed"]["strength"] == "nothing that is drawn depends on it"
