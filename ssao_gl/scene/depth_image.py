"""A depth image as its maker gives it, and the one place that settles its unit, kind, sign and background.

The result is linear depth: distance along the view axis in scene units, float32 (h, w), row 0 on top, 0 = background.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FormatError, SettingsError, one_line, warn_of_input
from .camera import Camera
from .depth_noise import denoise_depth

DEPTH_KINDS = {
    "eye": "distances above 0",
    "window": "values from 0 to 1",
    "ray": "distances above 0",
    "vtk": "distances below 0",
}
"""Kind -> its values: distance along the view axis; depth buffer; distance from the eye; distance along the view axis, negated."""
MAX_DEPTH_SIDE = 1 << 16
LEAST, MOST = 2.0**-63, 2.0**63
"""Distances that are taken; outside of them squares are no longer 32-bit floats."""
GAP = 3.0
"""A farthest value this many times as far as the next, held by a whole block of texels, is no surface."""
BLOCK = 3
"""Texels along a side of that block: the last rows of a floor and a ceiling before the horizon are constant, too."""
MIXED = 0.1
"""How many values beyond the others may go with it, of those that hold it."""


@dataclass(frozen=True, eq=False)
class DepthImage:
    """Depth in whatever form a file or a sensor gives it.

    values: (h, w), (h, w, 1) or (1, h, w) numbers, masked arrays too. kind: one of :data:`DEPTH_KINDS`; window depth of
    integers is normalized as OpenGL does. scale: scene units per unit of ``values`` (0.001: millimetres to metres).
    background: a stored value that is no surface, besides 0, inf, nan, the largest number of 16 or 32 bits, and one far
    constant; nan switches the search for a far constant off. mask: (h, w), nonzero where there is a surface. noise:
    standard deviation at distance 1 of an error that grows with the distance squared, scene units; 0 for none.
    empty: what is made of an image without any surface: "refuse", "warn" (as of frames of a stream) or "accept".
    """

    values: ArrayLike
    kind: str = "eye"
    scale: float | None = None
    background: float | None = None
    mask: ArrayLike | None = None
    noise: float = 0.0
    empty: Literal["refuse", "warn", "accept"] = "refuse"

    def __post_init__(self) -> None:
        if self.kind not in DEPTH_KINDS:
            raise SettingsError(
                f"depth kind '{self.kind}'; must be 'eye' (distance along the view axis), 'window' (0 to 1),"
                " 'ray' (distance from the eye) or 'vtk' (negative)"
            )
        if self.scale is not None and not (0 < self.scale < np.inf):
            raise SettingsError(f"depth scale {self.scale:g}: must be above 0 and finite (scene units per unit of depth)")
        if self.scale is not None and self.kind == "window":
            raise SettingsError("depth scale: window depth has no unit; leave the scale out")
        if not (0 <= self.noise < np.inf):
            raise SettingsError(f"depth noise {self.noise:g}: must be 0 or more, and finite")

    @classmethod
    def settled(cls, z: NDArray[Any]) -> DepthImage:
        """Return linear depth of which nothing is left to guess."""
        return cls(z, background=np.nan, empty="accept")

    @property
    def size(self) -> tuple[int, int]:
        """(width, height). Raises FormatError for what is no depth."""
        h, w = _plane(self.values).shape
        return w, h

    def linear(self, camera: Camera) -> NDArray[np.float32]:
        """Return linear depth for ``camera``. Warns of what is guessed.

        Raises FormatError for shapes and types that are no depth, for values of another kind, and when no texel is usable.
        """
        raw = _plane(self.values)
        if self._is_linear(raw):
            return raw.copy()
        absent = _absent(raw, self)
        with np.errstate(invalid="ignore"):  # of bits that are no number
            values = np.where(absent, np.nan, np.ma.getdata(raw).astype(np.float64))
        if self.kind == "window":
            z = _from_window(values / np.iinfo(raw.dtype).max if raw.dtype.kind in "iu" else values, camera)
        else:
            if self.scale is None and raw.dtype.kind in "iu":
                warn_of_input(
                    f"depth is {raw.dtype} without a scale: one step is one scene unit (a scale of 0.001 reads millimetres)"
                )
            z = _without_far_constant(_distances(values * (self.scale or 1.0), self.kind), self.background)
        z = np.where((z >= LEAST) & (z < MOST), z, 0.0)
        if self.kind == "ray":
            z = z / _ray_lengths(z.shape, camera)
        if not z.any():
            self._tell_empty(raw)
        elif self.noise:
            z = denoise_depth(z, camera, self.noise)
        return z.astype(np.float32)

    def _is_linear(self, raw: NDArray[Any]) -> bool:
        """Whether depth is linear as it stands, which a glance tells of most frames of a stream."""
        plain = self.kind == "eye" and self.scale in (None, 1.0) and self.mask is None and not self.noise
        if not plain or raw.dtype != np.float32 or np.ma.isMaskedArray(raw):
            return False
        with np.errstate(invalid="ignore"):
            low, high = float(raw.min()), float(raw.max())
        if not (low >= 0 and LEAST <= high < MOST):
            return False
        if self.background is not None:
            return bool(np.isnan(self.background))
        return int(np.count_nonzero(raw == high)) < BLOCK**2  # no far constant

    def _tell_empty(self, raw: NDArray[Any]) -> None:
        """Say that nothing is left, as :attr:`empty` asks. Raises FormatError."""
        text = (
            f"depth has no usable texel: {_told(raw)}; expected {DEPTH_KINDS[self.kind]} for kind '{self.kind}', with 0, inf or"
            " nan for background"
        )
        if self.empty == "refuse":
            raise FormatError(text)
        if self.empty == "warn":
            warn_of_input(text)


def _plane(values: ArrayLike) -> NDArray[Any]:
    """Return depth as (h, w). Raises FormatError."""
    try:
        array: NDArray[Any] = values if isinstance(values, np.ndarray) else np.asarray(values)
    except ValueError as error:
        raise FormatError(f"depth: expected an array; {one_line(error, 120)}") from None
    if array.dtype == object:
        raise FormatError(
            f"depth is a {type(values).__name__}; expected an array of numbers of shape (h, w), and the camera after it"
        )
    shape = array.shape
    if len(shape) == 3 and (shape[0] == 1 or shape[2] == 1):
        array = array[..., 0] if shape[2] == 1 else array[0]
    if array.ndim != 2 or array.dtype.kind not in "fiu" or not array.size:
        raise FormatError(f"depth is {array.dtype} of shape {shape}; expected numbers of shape (h, w), (h, w, 1) or (1, h, w)")
    if max(array.shape) > MAX_DEPTH_SIDE:
        raise FormatError(f"depth of shape {shape} is too large; sides may have {MAX_DEPTH_SIDE} texels")
    return array


def _absent(raw: NDArray[Any], image: DepthImage) -> NDArray[np.bool_]:
    """Return where masks, the background value and saturated integers say that there is no surface."""
    data = np.ma.getdata(raw)
    absent: NDArray[np.bool_] = np.ma.getmaskarray(raw).copy()
    if image.mask is not None:
        mask = _plane(np.asarray(image.mask).astype(np.float32))
        if mask.shape != raw.shape:
            raise FormatError(f"depth mask of shape {mask.shape}: expected the depth's {raw.shape}")
        absent |= mask == 0
    if image.background is not None and not np.isnan(image.background):
        absent |= np.isclose(data, image.background, rtol=1e-6, atol=0)
    elif raw.dtype.kind in "iu" and raw.dtype.itemsize > 1 and image.kind != "window":
        absent |= data == np.iinfo(raw.dtype).max
    return absent


def _distances(values: NDArray[np.float64], kind: str) -> NDArray[np.float64]:
    """Return distances above 0 where they are of that kind; VTK's are negative. Raises FormatError when all have the other sign."""
    known = np.isfinite(values) & (values != 0)
    wrong = known & ((values > 0) if kind == "vtk" else (values < 0))
    if wrong.any():
        count, finite = int(wrong.sum()), values[known]
        if count >= known.sum() > 0:
            span = f"{finite.min():g} to {finite.max():g}"
            advice = (
                "is negative, as VTK and PyVista give it: depth kind 'vtk' reads it"
                if kind != "vtk"
                else "is positive: depth kind 'eye' reads it"
            )
            raise FormatError(f"depth {advice} (all {count} values that are not background lie in {span})")
        warn_of_input(f"{count} of {values.size} depths have the wrong sign for depth kind '{kind}': taken as background")
    return -values if kind == "vtk" else values


def _without_far_constant(z: NDArray[np.float64], background: float | None) -> NDArray[np.float64]:
    """Return ``z`` without the one far value that stands for no surface: Blender's 1e10, a far plane.

    Blocks tell it from what is far by chance. A few values beyond the others go with it: smoothed edges mix both.
    """
    usable = np.isfinite(z) & (z > 0)
    if background is not None or not usable.any():
        return z
    far = z[usable].max()
    held = usable & (z == far)
    rest, mixed = z[usable & ~held], int(MIXED * held.sum())
    if rest.size <= mixed or not _has_block(held):
        return z
    limit = GAP * np.partition(rest, rest.size - 1 - mixed)[rest.size - 1 - mixed]
    if not LEAST < limit <= far:
        return z
    warn_of_input(
        f"{int(held.sum())} of {z.size} depths hold {far:g}, {GAP * far / limit:.3g} times as far as all others: taken as"
        " background (a background value of nan switches this off)"
    )
    return np.where(usable & (z > limit) | held, 0.0, z)


def _has_block(held: NDArray[np.bool_]) -> bool:
    """Return whether a square of :data:`BLOCK` texels a side is all true."""
    if min(held.shape) < BLOCK:
        return False
    return bool(np.lib.stride_tricks.sliding_window_view(held, (BLOCK, BLOCK)).all((2, 3)).any())


def _from_window(d: NDArray[np.float64], camera: Camera) -> NDArray[np.float64]:
    """Return linear depth of a depth buffer; its far plane is background. Raises FormatError when most lie outside 0..1."""
    h, w = d.shape
    outside = np.isfinite(d) & ((d < 0) | (d > 1))
    if outside.any():
        count, known = int(outside.sum()), int((np.isfinite(d) & (d != 0)).sum())
        if 2 * count > known:
            raise FormatError(f"depth kind 'window': {count} of {known} depths lie outside 0..1; are they distances (eye)?")
        warn_of_input(f"{count} of {known} window depths lie outside 0..1: taken as background")
    c = camera.view((w, h)).depth_constants
    u, v = np.meshgrid((np.arange(w) + 0.5) / w, 1 - (np.arange(h) + 0.5) / h)
    p = (u, v, d - c["u_depth_far"], 1.0)
    with np.errstate(all="ignore"):
        num, den = (sum(k * x for k, x in zip(c[name], p, strict=True)) for name in ("u_depth_num", "u_depth_den"))
        z = num / den
    absent = outside | ~np.isfinite(z) | (d == c["u_depth_far"])
    return np.where(absent, 0.0, z)


def _ray_lengths(shape: tuple[int, ...], camera: Camera) -> NDArray[np.float64] | float:
    """Return the distance from the eye of points at linear depth 1. Raises SettingsError."""
    view = camera.view((shape[1], shape[0]))
    if view.w1 == 0:
        return 1.0  # rays of a parallel projection run along the axis
    if not view.pinhole:
        raise SettingsError("depth kind 'ray': the camera's rays do not pass through the eye; give depth along the view axis")
    lengths: NDArray[np.float64] = np.linalg.norm(view.points(np.ones(shape)), axis=-1)
    return lengths


def _told(raw: NDArray[Any]) -> str:
    """Say what an array without depth holds."""
    values = np.ma.getdata(raw)
    finite = values[np.isfinite(values)]
    span = f"{finite.min():g} to {finite.max():g}" if finite.size else "no finite number"
    return f"{values.dtype}, {span}, {int(np.isnan(values).sum())} nan of {values.size}"
