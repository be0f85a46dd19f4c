"""Tests of ``experiment/variants.py``."""

from __future__ import annotations

from ssao_gl.experiment import variants


def test_variants_are_presets_or_ranges() -> None:
    names = [variant.label for variant in variants.variants(["alchemy"])]
    assert {"alchemy draft", "alchemy high"} <= set(names)
    assert [v.label for v in variants.variants(["lecture"], ["8"])] == ["lecture 8"]
    swept = variants.variants(["alchemy", "lecture"], ranges=["alchemy.samples=3,5", "alchemy.bias=0.002"])
    assert [v.label for v in swept][:2] == ["alchemy samples=3 bias=0.002", "alchemy samples=5 bias=0.002"]
    assert swept[1].settings.method.samples == 5  # type: ignore[attr-defined]
    assert "reference" not in {one.family for one in variants.variants()}
