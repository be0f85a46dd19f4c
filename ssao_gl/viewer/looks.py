"""The methods and presets that a browser offers, as pipelines of its runtime."""

from __future__ import annotations

from ..export.pipeline import Pipeline, PipelineInputs, pipeline
from ..export.write import slim
from ..methods.registry import method, presets_of
from ..pipeline.settings import Settings

OFFERED = ("bitmask", "gtao", "hbao", "alchemy", "starcraft2", "lecture")
GIVEN = PipelineInputs("window", normals=True)
"""What the browser draws of a scene: its depth buffer, and normals."""


def offered() -> dict[str, Settings]:
    """Return the settings of every method that is offered, at each of its presets, by names like "bitmask high"."""
    made = {}
    for name in OFFERED:
        for chosen in presets_of(name) or ("",):
            made[f"{name} {chosen}".strip()] = Settings(method=method(name, chosen))
    return made


def look_pipeline(settings: Settings) -> Pipeline:
    """Return the pipeline of some settings; without a radius it has 1, which the browser sets. Raises SettingsError, GraphError."""
    if settings.method.radius is None:
        settings = settings.with_radius(1.0)
    return slim(pipeline(settings, GIVEN))
