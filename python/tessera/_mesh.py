"""Bytes of meshes and of pictures in memory (proto/wire/mesh_blob.h; PFM)."""

from __future__ import annotations

import struct

import numpy as np
import numpy.typing as npt

_HAS_NORMALS, _HAS_UVS = 1, 2


def _array(values: npt.ArrayLike, columns: int, what: str) -> npt.NDArray[np.float32]:
    array = np.ascontiguousarray(values, dtype="<f4")
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"{what}: expected an array of shape (n, {columns}), not {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{what}: not all values are finite")
    return array


def encode_mesh(
    vertices: npt.ArrayLike,
    triangles: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    uvs: npt.ArrayLike | None = None,
) -> bytes:
    """The blob of a mesh: `vertices` and `normals` (n, 3), `uvs` (n, 2), `triangles` (m, 3) with indices of
    vertices. ValueError for arrays that do not fit one another."""
    positions = _array(vertices, 3, "vertices")
    faces = np.asarray(triangles)
    if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer):
        raise ValueError(f"triangles: expected integers of shape (n, 3), not {faces.dtype} {faces.shape}")
    if faces.size and (faces.min() < 0 or faces.max() >= len(positions)):
        raise ValueError(f"triangles: an index is not below the {len(positions)} vertices")
    arrays = [positions]
    flags = 0
    if normals is not None:
        flags |= _HAS_NORMALS
        arrays.append(_array(normals, 3, "normals"))
    if uvs is not None:
        flags |= _HAS_UVS
        arrays.append(_array(uvs, 2, "uvs"))
    if any(len(array) != len(positions) for array in arrays):
        raise ValueError("normals and uvs: expected one a vertex")
    blob = bytearray(b"TSRMESH1" + struct.pack("<IIQQ", flags, 0, len(positions), len(faces)))
    for array in arrays:
        blob += array.tobytes()
        blob += bytes(-len(blob) % 16)
    return bytes(blob + np.ascontiguousarray(faces, dtype="<u4").tobytes())


def encode_pfm(pixels: npt.ArrayLike) -> bytes:
    """A picture, (height, width, 3) or (height, width), rows from the top, as a Portable Float Map."""
    array = np.asarray(pixels, dtype="<f4")
    if array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] != 3) or array.size == 0:
        raise ValueError(f"expected an array of shape (height, width) or (height, width, 3), not {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("a picture: not all values are finite")
    kind = "PF" if array.ndim == 3 else "Pf"
    header = f"{kind}\n{array.shape[1]} {array.shape[0]}\n-1.0\n".encode()
    return header + np.ascontiguousarray(array[::-1]).tobytes()
