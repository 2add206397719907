"""Pictures to look at."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt


def to_srgb(linear: npt.NDArray[np.floating[Any]], exposure: float = 0.0) -> npt.NDArray[np.uint8]:
    """Linear Rec.709, scaled by 2^exposure and clamped to [0, 1], in the encoding of sRGB [IEC 61966-2-1]."""
    x = np.clip(np.asarray(linear, np.float64) * 2.0**exposure, 0, 1)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    eight_bits: npt.NDArray[np.uint8] = np.round(255 * encoded).astype(np.uint8)
    return eight_bits


def write_png(path: str | Path, pixels: npt.NDArray[np.uint8]) -> None:
    """Writes 8-bit pixels (height, width, 3), rows from the top."""
    height, width, bands = pixels.shape
    if bands != 3 or pixels.dtype != np.uint8:
        raise ValueError(f"expected 8-bit pixels (height, width, 3), not {pixels.dtype} {pixels.shape}")
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    Path(path).write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows.tobytes()))
        + chunk(b"IEND", b"")
    )
