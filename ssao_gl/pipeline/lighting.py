"""From the light of settings to passes: the shadow map, what is drawn beside visibility for it, and the image."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import SettingsError
from ..graph.declare import DepthTest, Pass
from ..graph.names import BENT_NORMAL, GAINED
from ..passes.light import Sources, light_image, reflected_light, shadow_map
from .light import Light
from .settings import Settings, drawn_scale

Signals = tuple[str, ...]
"""What is drawn and filtered beside visibility."""

WHAT = {BENT_NORMAL: ("bent", "which directions are open"), GAINED: ("indirect", "what hides a pixel")}


def signals_of(settings: Settings, light: Light | None, *, bent: bool) -> Signals:
    """Return the signals beside visibility that a frame needs. ``bent``: bent normals are wanted for themselves.

    Raises SettingsError where they cannot be had.
    """
    wanted = [BENT_NORMAL] if bent or _bent_sky(settings, light) else []
    wanted += [GAINED] if light is not None and light.bounces else []
    for signal in wanted:
        _check(settings, signal)
    return tuple(wanted)


def light_before_occlusion(settings: Settings, light: Light | None) -> list[Pass]:
    """Return the passes of light that occlusion may read."""
    if light is None:
        return []
    passes = [shadow_map(light.shadow_side)] if light.casts else []
    if light.bounces:
        passes.append(reflected_light(_sources(light), drawn_scale(settings), light.hidden_sky))
    return passes


def lit_image(settings: Settings, light: Light, background: Sequence[float], test: DepthTest | None, result: str) -> Pass:
    """Return the pass that lights the image."""
    return light_image(
        _sources(light), background, bent=_bent_sky(settings, light),
        specular=light.specular, indirect=light.indirect, hidden_sky=light.hidden_sky, tone=light.tone, test=test, result=result,
    )  # fmt: skip


def _sources(light: Light) -> Sources:
    return Sources(light.lamp_slots, light.casts, not light.even)


def _bent_sky(settings: Settings, light: Light | None) -> bool:
    """Return whether the environment is looked up in the direction that is open: where it matters, and can be had."""
    return light is not None and not light.even and not any(_lacks(settings, BENT_NORMAL))


def _lacks(settings: Settings, signal: str) -> tuple[bool, bool]:
    """Return whether the method, and whether the filter, knows nothing of a signal."""
    return (
        signal not in settings.method.traits.outputs,
        settings.blur is not None and signal not in settings.blur.traits.carries,
    )


def _check(settings: Settings, signal: str) -> None:
    """Raise SettingsError where a signal cannot be had."""
    (method, blur), (name, what) = _lacks(settings, signal), WHAT[signal]
    if method:
        raise SettingsError(f"{name}: {settings.method.name} does not know {what}; use the method bitmask")
    if blur and settings.blur is not None:
        raise SettingsError(f"{name}: the filter {settings.blur.name} is for visibility alone; use joint, or none")
