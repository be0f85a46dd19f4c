"""From the light of settings to passes: the shadow map, what is drawn beside visibility for it, and the image."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import SettingsError
from ..graph.declare import DepthTest, Pass
from ..graph.names import BENT_NORMAL, GAINED
from ..passes.gather import Gathering, from_screen, from_shadow_map
from ..passes.light import Sources, light_image, reflected_light, shadow_map
from .light import Light
from .settings import Settings, drawn_filter, drawn_scale

Signals = tuple[str, ...]
"""What is drawn and filtered beside visibility."""

WHAT = {BENT_NORMAL: ("bent", "which directions are open"), GAINED: ("indirect", "what hides a pixel")}


def signals_of(settings: Settings, light: Light | None, *, bent: bool) -> Signals:
    """Return the signals beside visibility that a frame needs. ``bent``: bent normals are wanted for themselves.

    Raises SettingsError where they cannot be had.
    """
    wanted = [BENT_NORMAL] if bent or _bent_sky(settings, light) else []
    wanted += [GAINED] if light is not None and light.bounces else []
    if light is not None and light.gathers:
        _check_gathering(settings, light)
    for signal in wanted:
        _check(settings, signal, by_method=not (signal == GAINED and light is not None and light.gathers))
    return tuple(wanted)


def signals_by_taps(settings: Settings, signals: Signals) -> Signals:
    """Return those of the signals that the method itself draws."""
    return tuple(s for s in signals if s != GAINED or not (settings.light and settings.light.gathers))


def light_beside_occlusion(
    settings: Settings, signals: Signals, *, packed: bool, scale: int = 1, test: DepthTest | None
) -> list[Pass]:
    """Return the pass that gathers light beside occlusion, drawn for the same pixels, where there is one."""
    light, method = settings.light, settings.method
    if light is None or method.radius is None or signals == signals_by_taps(settings, signals):
        return []
    filtered, traits = drawn_filter(settings) is not None, method.traits
    job = Gathering(
        light.gather_taps, float(method.radius), traits.max_reach or 0.0, traits.noise_tile, filtered, packed, scale, test
    )
    return [from_shadow_map(job) if light.indirect == "rsm" else from_screen(job)]


def light_before_occlusion(settings: Settings, light: Light | None) -> list[Pass]:
    """Return the passes of light that occlusion may read."""
    if light is None:
        return []
    passes = [shadow_map(light.shadow_side, reflective=light.indirect == "rsm")] if light.casts else []
    if light.indirect in ("bitmask", "ssdo"):
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


def _check_gathering(settings: Settings, light: Light) -> None:
    """Raise SettingsError where light cannot be gathered beside occlusion."""
    method, traits = settings.method, settings.method.traits
    if light.indirect == "rsm" and not light.casts:
        raise SettingsError("indirect=rsm: gathers from a shadow map, and there is none; use --shadows, with a key light")
    if not traits.noise_tile or traits.radius_unit != "scene units":
        raise SettingsError(
            f"indirect={light.indirect}: shares radius and noise with the method, and {method.name} lacks them; use bitmask"
        )


def _check(settings: Settings, signal: str, *, by_method: bool = True) -> None:
    """Raise SettingsError where a signal cannot be had. by_method: the method is to draw it."""
    (method, blur), (name, what) = _lacks(settings, signal), WHAT[signal]
    if method and by_method:
        raise SettingsError(f"{name}: {settings.method.name} does not know {what}; use the method bitmask")
    if blur and settings.blur is not None:
        raise SettingsError(f"{name}: the filter {settings.blur.name} is for visibility alone; use joint, or none")
