"""What a picture lacks to rays, predicted from what is known of its view before it is drawn.

The RMSE of visibility is taken for a sum of shares of the view's :class:`~.signs.ViewFeatures`, with weights that are not negative and were
fitted once, for each candidate, to pictures of the report's views against rays: ``ssao-gl planner fit``
makes ``errors.json`` anew.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

from .features import ViewFeatures

SIGNS: Mapping[int, tuple[str, ...]] = {1: ("sampling", "rough", "contrast"), 2: ("sampling", "hidden", "rough")}
"""Number of layers that can be had -> the signs that predict."""


@cache
def error_weights() -> Mapping[str, Any]:
    """``errors.json``: by the number of layers that can be had, candidate -> weights of the signs, and mean RMSE."""
    return json.loads(resources.files(__package__).joinpath("errors.json").read_text("utf-8"))  # type: ignore[no-any-return]


def predicted(name: str, signs: ViewFeatures, layers: int) -> float:
    """RMSE against rays of the candidate ``name``; ``layers``: 2 where a renderer draws the scene, 1 for arrays."""
    weights = error_weights()[str(layers)][name]["weights"]
    return float(sum(weight * getattr(signs, sign) for sign, weight in weights.items()))
