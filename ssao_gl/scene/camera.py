"""Cameras: a lens, and a pose.

``pose`` is camera-to-world in OpenGL axes (as in glTF, pyrender and trimesh). See :mod:`ssao_gl.scene.projection` for the conventions.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingsError, encodable, near_miss, one_line
from .lens import (
    ClipRange,
    CropLens,
    Lens,
    Orthographic,
    Perspective,
    Pinhole,
    Projection,
    intrinsics_of,
    lens_of,
    lens_table,
)  # fmt: skip
from .pose import TURN, Axes, inverse, look_at, matrix4, pose_of, rigid
from .projection import Matrix, Size, ViewConstants


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A lens and where it stands: ``pose`` is the (4, 4) camera-to-world matrix in OpenGL axes."""

    lens: Lens
    pose: Matrix = field(default_factory=lambda: np.eye(4))
    name: str = ""
    ao_radius: float | None = None
    """A radius in scene units that suits this view, when its file names one."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", rigid(self.pose))

    @classmethod
    def perspective(cls, yfov: float, znear: float = 0.01, zfar: float | None = None, pose: ArrayLike | None = None) -> Camera:
        """Return a symmetric perspective camera; ``yfov`` in radians, ``zfar=None`` for an infinite far plane."""
        return cls(Perspective(yfov, znear, zfar), pose_of(pose))

    @classmethod
    def orthographic(cls, height: float, znear: float, zfar: float, pose: ArrayLike | None = None) -> Camera:
        """Return a parallel projection that shows ``height`` scene units from bottom to top."""
        return cls(Orthographic(height, znear, zfar), pose_of(pose))

    @classmethod
    def pinhole(
        cls,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        size: Size,
        *,
        znear: float = 0.01,
        zfar: float | None = None,
        pose: ArrayLike | None = None,
        world_to_camera: ArrayLike | None = None,
        axes: Axes | None = None,
    ) -> Camera:
        """OpenCV or COLMAP intrinsics in pixels of an image of ``size`` (width, height).

        ``pose`` is camera-to-world, in OpenGL axes unless ``axes`` says "opencv" (x right, y down, z forward);
        ``world_to_camera`` is the extrinsic matrix, in OpenCV axes unless it says "opengl". Both (4, 4) or (3, 4). Give at
        most one. Raises SettingsError for matrices that do more than turn and move.
        """
        try:
            w, h = size
        except (TypeError, ValueError):
            raise SettingsError(f"camera: size={size!r}; must be (width, height) of the image in pixels") from None
        return cls(Pinhole(fx, fy, cx, cy, w, h, znear, zfar), pose_of(pose, world_to_camera, axes))

    @classmethod
    def from_intrinsics(
        cls, k: ArrayLike, size: Size, *, pose: ArrayLike | None = None, world_to_camera: ArrayLike | None = None,
        axes: Axes | None = None, znear: float = 0.01, zfar: float | None = None,
    ) -> Camera:  # fmt: skip
        """Return the camera of a calibration matrix ``k`` (3, 3), pixels; the rest as in :meth:`pinhole`.

        Raises SettingsError for what is no such matrix, and for skew.
        """
        fx, fy, cx, cy = intrinsics_of(k)
        return cls.pinhole(
            fx, fy, cx, cy, size, pose=pose, world_to_camera=world_to_camera, axes=axes, znear=znear, zfar=zfar
        )  # fmt: skip

    @classmethod
    def from_matrix(cls, projection: ArrayLike, pose: ArrayLike | None = None, clip: ClipRange = "-1..1") -> Camera:
        """Any projection matrix (4, 4), row-major: off-centre, reversed, infinite, oblique; ``clip`` is its depth range."""
        if clip not in ("-1..1", "0..1"):
            raise SettingsError(f"camera: clip={clip!r}; must be '-1..1' or '0..1'")
        return cls(Projection(matrix4(projection, "projection"), clip), pose_of(pose))

    def view(self, size: Size) -> ViewConstants:
        """Return the constants for an image of ``size`` (width, height). Raises SettingsError when the projection is
        unusable."""
        return _view(self.lens, size)

    def named(self, name: str) -> Camera:
        """Return the same camera under another name."""
        return replace(self, name=name)

    @property
    def world_to_camera(self) -> Matrix:
        """The extrinsic matrix (4, 4) in OpenCV axes (x right, y down, z forward)."""
        return TURN @ inverse(self.pose)

    def intrinsics(self, size: Size) -> Matrix:
        """Return the calibration matrix (3, 3) for an image of ``size`` (width, height), pixels, row 0 on top.

        Pixel centres lie at whole numbers + 0.5. Raises SettingsError for cameras whose rays do not meet in the eye.
        """
        if not self.view(size).pinhole:
            raise SettingsError("camera: intrinsics are for perspective cameras only")
        (w, h), m = size, self.lens.matrix(size) / self.view(size).w1
        across, down = np.array([w / 2, -h / 2]), np.array([w / 2, h / 2])
        k = np.eye(3)
        k[:2, :2] = across[:, None] * m[:2, :2] * (1, -1)
        k[:2, 2] = down - across * m[:2, 2]
        return k

    def to_json(self) -> str:
        """Return the camera as JSON: an entry of a camera file. Raises SettingsError for a lens of another package."""
        table: dict[str, Any] = {"name": self.name, "pose": self.pose.tolist(), **lens_table(self.lens)}
        return json.dumps(table if self.ao_radius is None else {**table, "ao_radius": self.ao_radius})

    @classmethod
    def from_json(cls, text: str | Mapping[str, Any]) -> Camera:
        """Return the camera of an entry of a camera file: ``pose`` (4, 4), or ``eye``, ``target`` and ``up``; and a lens.

        Raises SettingsError.
        """
        try:
            table = json.loads(text) if isinstance(text, str) else dict(text)
            if not isinstance(table, dict):
                raise SettingsError("camera: expected an object")
            if "pose" in table:
                pose = rigid(table["pose"])
            else:
                pose = look_at(table["eye"], table["target"], table.get("up", (0, 1, 0)))
            radius = None if table.get("ao_radius") is None else float(table["ao_radius"])
            lens = lens_of(table)
        except KeyError as error:
            raise SettingsError(f"camera: lacks {error}.{near_miss(str(error.args[0]), table)}") from None
        except (TypeError, ValueError, OverflowError, RecursionError) as error:
            raise SettingsError(f"camera: {one_line(error)}") from None
        if radius is not None and not 0 < radius < math.inf:
            raise SettingsError(f"camera: ao_radius={radius} must be above 0 and finite")
        return cls(lens, pose, encodable(str(table.get("name") or "")), radius)


@lru_cache(maxsize=64)
def _view(lens: Lens, size: Size) -> ViewConstants:
    """Return the constants of a lens: a moving camera keeps them, and with them every uniform that is already set."""
    return ViewConstants(size, lens.matrix(size), lens.whole if isinstance(lens, CropLens) else None)
