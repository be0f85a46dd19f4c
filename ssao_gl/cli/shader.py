"""``ssao-gl shader``: the exact text that the driver gets."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Annotated

from cyclopts import Parameter

from ..errors import SettingsError
from ..glsl import preprocess
from ..methods.registry import registry
from ..settings import assign

EXAMPLES: Mapping[str, Mapping[str, preprocess.Define]] = {
    "gbuffer.frag": {"TARGETS": 3, "DEPTH_TARGET": 0, "NORMAL_TARGET": 1, "COLOR": 2, "NORMAL": 1, "SMOOTH": 1},
    "gbuffer.vert": {"NORMAL": 1, "SMOOTH": 1},
    "pack_visibility.frag": {"PACKED": 1},
    "denoise_joint.frag": {"PACKED": 1, "RADIUS": 2, "LAST": 1, "PINHOLE": 1},
    "upsample.frag": {"PACKED": 1, "PINHOLE": 1},
    "downsample.frag": {"TARGETS": 2, "SCALE": 2, "PIXELS": 4},
    "block_bounds.frag": {"TARGETS": 2, "BLOCK": 16, "BELOW": 17},
    "open_blocks.frag": {"BLOCK": 16},
    "depth_range.frag": {"BLOCK": 8, "SCALE": 4},
    "depth_table.frag": {"TARGETS": 1, "SCALE": 4, "STRIDE_X": 1, "STRIDE_Y": 0, "FIRST": 1},
    "upsample_depth.frag": {"PACKED": 1, "PINHOLE": 1},
    "halo.frag": {"SCALE": 4},
    "residual_filter.frag": {"RADIUS": 5},
    "gather_rsm.frag": {"TAPS": 32},
    "gather_ssdo.frag": {"TAPS": 32},
    "resolve_mean.frag": {"SIDE": 2, "SAMPLES": 4, "SRGB": 1, "ALPHA": 1},
    "resolve_median.frag": {"SIDE": 2, "SAMPLES": 4, "TARGETS": 2, "Z": 0, "NORMAL": 1},
    "temporal.frag": {"TARGETS": 2},
    "denoise_intensity.frag": {"PACKED": 1, "RADIUS": 4, "WIDTH": 4, "HEIGHT": 4, "LAST": 1},
}
"""Defines that a shader cannot do without, as the default settings give them."""


def shader(
    name: str | None = None,
    *,
    dialect: Annotated[str, Parameter(help=f"One of {', '.join(preprocess.DIALECTS)}.")] = "es300",
    define: Annotated[
        tuple[str, ...],
        Parameter(help="NAME or NAME=VALUE, over the defaults; may be repeated.", negative="", show_default=False),
    ] = (),
) -> int:
    """Print a shader, complete for one GLSL dialect.

    Parameters
    ----------
    name
        A method (alchemy) or a shader file (denoise_joint.frag). Without it: the list of both.
    """
    if name is None:
        sys.stdout.write("\n".join([*registry(), *preprocess.names()]) + "\n")
        return 0
    methods = registry()
    file = methods[name].shader if name in methods else name
    defines = dict(defaults(file))
    for text in define:
        key, _, value = text.partition("=")
        if not key.isidentifier():
            raise SettingsError(f"--define {text}: must be NAME or NAME=VALUE")
        defines[key] = value or 1
    sys.stdout.write(preprocess.build(file, defines, dialect).text)
    return 0


def defaults(file: str) -> Mapping[str, preprocess.Define]:
    """Return the defines that the default settings give a shader file."""
    for kind in registry().values():
        if kind.shader == file:
            made = kind()
            settled = made if made.radius is not None else assign(made, {"radius": 1.0})  # which some need for their defines
            return {**settled.defines(), "PINHOLE": 1}
    return EXAMPLES.get(file, {})
