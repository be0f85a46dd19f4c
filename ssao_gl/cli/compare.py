"""``ssao-gl compare``: how far two pictures are apart, with an exit code for scripts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import SettingsError
from ..io import images
from ..metrics.images import compare as compare_pictures
from ..metrics.images import difference_picture
from .output import check_output, say


def compare(
    actual: Path,
    expected: Path,
    *,
    max_abs: Annotated[
        float | None,
        Parameter(
            help="Exit with 1 when any value differs by more (1/255 for PNG, the array's own unit for floats). [default: no limit]"
        ),
    ] = None,
    metric: Annotated[
        str, Parameter(help="More numbers, by commas: rmse, psnr (dB), ssim, flip. [default: none]", show_default=False)
    ] = "",
    diff: Annotated[
        Path | None,
        Parameter(
            allow_leading_hyphen=True, help="Write actual | expected | difference x 16 to this PNG file. [default: none]"
        ),
    ] = None,
) -> int:
    """Compare two pictures or arrays.

    Parameters
    ----------
    actual
        PNG, NPY or EXR.
    expected
        One of the same size.
    """
    if max_abs is not None and not max_abs >= 0:
        raise SettingsError(f"--max-abs {max_abs:g}: must be at least 0")
    if diff is not None:
        check_output("--diff", diff, (".png",))
    found = compare_pictures(actual, expected, [name.strip() for name in metric.split(",") if name.strip()])
    if diff is not None:
        images.save_image(diff, difference_picture(actual, expected))
    over = max_abs is not None and not found.max_abs <= max_abs
    say(found.describe() + (f"; over the limit of {max_abs:g}" if over else ""))
    return 1 if over else 0
