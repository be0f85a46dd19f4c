"""Settings from names, TOML and key=value texts, and which of them wins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssao_gl.errors import SettingsError
from ssao_gl.methods.registry import registry
from ssao_gl.passes.denoise import FILTERS, Joint
from ssao_gl.pipeline.presets import read_toml, settings_from
from ssao_gl.pipeline.settings import CULLING_RULES, Settings


def test_defaults() -> None:
    assert settings_from() == settings_from({}) == Settings()


def test_precedence(tmp_path: Path) -> None:
    """Defaults < file < names < key=value < options of their own."""
    path = tmp_path / "a.toml"
    path.write_text(
        'method = "lecture"\nblur = "separable"\n[lecture]\nradius = 0.5\nsamples = 8\n'
        '[alchemy]\nradius = 2.0\nsamples = 20\n[blur_separable]\nradius = 3\n[shading]\nbackground = "#102030"\n'
    )
    table = read_toml(path)
    found = settings_from(table)
    assert (found.method.name, found.method.radius) == ("lecture", 0.5)
    assert found.shading.background == "#102030"
    found = settings_from(table, method_name="alchemy", assignments=["radius=3"])
    assert (found.method.name, found.method.radius) == ("alchemy", 3.0)
    assert found.method.samples == 20  # type: ignore[attr-defined]
    found = settings_from(table, assignments=["radius=1.5"], overrides={"radius": 1.75, "samples": None})
    assert found.method.radius == 1.75


def test_groups() -> None:
    found = settings_from(
        assignments=["blur.radius=3", "shading.ambient=0.5", "alchemy.samples=9", "method.seed=4"], method_name="alchemy"
    )
    assert found.blur == Joint(radius=3) and found.shading.ambient == 0.5
    assert found.method.samples == 9 and found.method.seed == 4  # type: ignore[attr-defined]
    assert settings_from(blur_name="none").blur is None
    assert settings_from(assignments=["blur_joint.radius = 5"]).blur == Joint(radius=5)


def test_presets() -> None:
    assert settings_from(preset_name="medium") == Settings()
    ultra = settings_from(preset_name="ultra", assignments=["steps=9"]).method
    assert (ultra.scale, ultra.steps) == (1, 9)  # type: ignore[attr-defined]
    assert settings_from({"preset": "high"}, preset_name="draft").method == settings_from(preset_name="draft").method
    assert settings_from({"preset": "high", "bitmask": {"steps": 3}}).method.steps == 3  # type: ignore[attr-defined]


def test_keep() -> None:
    assert settings_from({"keep": ["background"]}) == settings_from(keep=["background"])
    assert settings_from(keep=["all"]).keep == tuple(CULLING_RULES)


def test_blur_as_table_sets_the_default_filter() -> None:
    assert settings_from({"blur": {"radius": 4}}).blur == Joint(radius=4)
    assert settings_from({"blur_joint": {"radius": 4}}, blur_name="lecture") == settings_from(blur_name="lecture"), (
        "others' may stay"
    )


@pytest.mark.parametrize(("text", "value"), [("auto", None), ("none", None), ("0.25", 0.25), ("1e-3", 1e-3), (" 2 ", 2.0)])
def test_texts_become_numbers(text: str, value: float | None) -> None:
    assert settings_from(assignments=[f"radius={text}"]).method.radius == value


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"method_name": "alchmy"}, "unknown method 'alchmy'.*Did you mean 'alchemy'"),
        ({"blur_name": "jont"}, "unknown blur 'jont'.*Did you mean 'joint'"),
        ({"assignments": ["radius"]}, "must be key=value"),
        ({"assignments": ["radus=1"]}, "no setting 'radus'.*Did you mean 'radius'"),
        ({"assignments": ["lecture.radius=1"]}, "the method is bitmask, not lecture; add --method lecture"),
        ({"assignments": ["blu.radius=1"]}, "unknown group of settings 'blu'.*Did you mean 'blur'"),
        ({"assignments": ["blur.radius=1"], "blur_name": "none"}, "blur is 'none'"),
        ({"assignments": ["steps=many"]}, "bitmask.steps='many': must be a whole number"),
        ({"assignments": ["steps=9" + "9" * 500]}, "must be a finite whole number"),
        ({"overrides": {"taps": 3}}, "--taps: bitmask has no such setting"),
        ({"table": {"radius": 3}}, r"unknown setting 'radius'; groups are tables, like \[bitmask\]"),
        ({"table": {"method": 3}}, "must be a name in quotes"),
        ({"table": {"bitmask": {"radius": "far"}}}, "must be a number"),
        ({"table": {"bitmask": {"radius": True}}}, "must be a finite number"),
        ({"table": {"bitmask": {"radius": 10**400}}}, "must be a finite number"),
        ({"table": {"bitmask": {"steps": 3.5}}}, "must be a finite whole number"),
        ({"table": {"shading": {"background": 3}}}, "must be text"),
        ({"preset_name": "hihg"}, "bitmask has no preset 'hihg'.*Did you mean 'high'"),
        ({"preset_name": "high", "method_name": "lecture"}, "lecture has no preset 'high'; it has "),
        ({"assignments": ["scale=3"]}, "bitmask.scale=3: must be one of 1, 2, 4"),
        ({"keep": ["sky"]}, "keep='sky': there is no such rule"),
        ({"table": {"keep": "all"}}, "keep = 'all': must be a list of names"),
    ],
)
def test_errors(arguments: dict[str, Any], expected: str) -> None:
    with pytest.raises(SettingsError, match=expected):
        settings_from(arguments.pop("table", None), **arguments)


@given(st.text(max_size=40))
def test_any_text_is_a_setting_or_an_error(text: str) -> None:
    try:
        settings_from(assignments=[text])
    except SettingsError as error:
        assert str(error)


@given(
    st.dictionaries(
        st.sampled_from(["method", "blur", "shading", "alchemy", "lecture", "blur_joint", "radius", "x"]),
        st.recursive(
            st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.dates(),
            lambda inner: (
                st.lists(inner, max_size=2)
                | st.dictionaries(st.sampled_from(["radius", "samples", "ambient"]), inner, max_size=2)
            ),
            max_leaves=4,
        ),
        max_size=3,
    )
)
def test_any_table_is_settings_or_an_error(table: dict[str, Any]) -> None:
    try:
        settings_from(table)
    except SettingsError as error:
        assert str(error)


def test_every_method_and_filter_by_name() -> None:
    for name in registry():
        assert settings_from(method_name=name).method.name == name
    for name in FILTERS:
        found = settings_from(blur_name=name).blur
        assert found is not None and found.name == name
