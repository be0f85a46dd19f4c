"""EXT_meshopt_compression of glTF: views unpacked by the package meshoptimizer, which is an extra."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError

MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
Bytes = NDArray[np.uint8]


def need_meshopt() -> Any:
    """The decoder of meshoptimizer. Raises SceneError that names the cure."""
    try:
        from meshoptimizer import decoder
    except ImportError:
        raise SceneError(
            "is compressed with EXT_meshopt_compression; pip install 'ssao_gl[meshopt]', or export it without"
        ) from None
    return decoder


def unpack_meshopt(packed: Bytes, entry: dict[str, Any]) -> Bytes:
    """Bytes of a view: ``count`` rows of ``byteStride`` bytes. Raises SceneError."""
    decoder = need_meshopt()
    count, stride, mode = int(entry["count"]), int(entry["byteStride"]), entry["mode"]
    if count < 0 or stride < 1:
        raise SceneError(f"has a compressed part of {count} rows of {stride} bytes; it is broken")
    content = packed.tobytes()
    try:
        if mode == "ATTRIBUTES":
            rows = decoder.decode_vertex_buffer(count, stride, content, np.dtype((np.uint8, stride)))
            return _filtered(decoder, rows, count, stride, entry.get("filter", "NONE"))
        if mode not in ("TRIANGLES", "INDICES"):
            raise SceneError(f"has a part compressed in the mode '{mode}', which is not known")
        if stride not in (2, 4) or (mode == "TRIANGLES" and count % 3):
            raise SceneError(f"has {count} compressed indices of {stride} bytes; it is broken")
        decode = decoder.decode_index_buffer if mode == "TRIANGLES" else decoder.decode_index_sequence
        indices = decode(count, 4, content)
    except (RuntimeError, ValueError) as error:
        raise SceneError(f"has a compressed part that cannot be unpacked ({error}); it is broken") from None
    return np.ascontiguousarray(indices.astype(f"<u{stride}")).view(np.uint8)


def _filtered(decoder: Any, rows: Bytes, count: int, stride: int, kind: str) -> Bytes:
    filters = {
        "OCTAHEDRAL": (decoder.decode_filter_oct, (4, 8)),
        "QUATERNION": (decoder.decode_filter_quat, (8,)),
        "EXPONENTIAL": (decoder.decode_filter_exp, tuple(range(4, 257, 4))),
    }
    flat: Bytes = np.ascontiguousarray(rows).reshape(-1)
    if kind == "NONE":
        return flat
    if kind not in filters or stride not in filters[kind][1]:
        raise SceneError(f"has a part compressed with the filter '{kind}' of {stride} bytes, which is not known")
    unpacked: Bytes = filters[kind][0](flat, count, stride)
    return unpacked
