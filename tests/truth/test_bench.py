"""Tests of ``truth/bench.py``."""

from __future__ import annotations

from ssao_gl.truth import Surface, Tracing
from ssao_gl.truth.bench import bench


def test_benchmark_traces_the_same_rays(seen: Surface) -> None:
    speeds = bench(seen, Tracing(radius=0.7, spp=16), rounds=1)  # raises when the hits differ
    assert 1 in speeds and all(bare > 0 and traced > 0 for bare, traced in speeds.values())
