"""Tile results, and the picture that they make (proto/wire/tile_result.h, client/image/assemble.h).

The arithmetic is that of the programs, operation by operation, so that a picture has the bits of `tessera fetch`
(docs/decisions/0003-result-layout.md).
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import zstandard

from tessera._wire import TesseraError
from tessera.v1 import job_pb2

Floats = npt.NDArray[np.float32]
Counts = npt.NDArray[np.uint32]

_MAX_PIXELS = 1 << 24
_MAX_CHANNELS = 640
_SUM, _SQUARED_DEVIATION, _FIRST = 0, 1, 2


@dataclass(frozen=True)
class Rect:
    """Pixels [x0, x1) x [y0, y1) of the film; (0, 0) is the upper left one."""

    x0: int
    y0: int
    x1: int
    y1: int

    @property
    def width(self) -> int:
        return self.x1 - self.x0

    @property
    def height(self) -> int:
        return self.y1 - self.y0

    def contains(self, other: Rect) -> bool:
        return self.x0 <= other.x0 and self.y0 <= other.y0 and other.x1 <= self.x1 and other.y1 <= self.y1


@dataclass(frozen=True)
class Channel:
    """A plane of a result: its name, how two nodes of it merge, and which sum its deviations are of."""

    name: str
    kind: int = _SUM
    of: int = 0


@dataclass
class TileResult:
    """Nodes of the sum trees of a rectangle of pixels, all over samples [begin, end)."""

    pixels: Rect
    begin: int
    end: int
    channels: tuple[Channel, ...]
    counts: Counts  # (height, width)
    values: Floats  # (channels, height, width)


def decode_tile(payload: bytes) -> TileResult:
    """Reads a result. TesseraError, with what is wrong, for bytes that are none; nothing larger than 2^24
    pixels of 640 channels is made of them."""

    def unsound(what: str) -> TesseraError:
        return TesseraError(f"tile result: {what}")

    if len(payload) < 36 or payload[:8] != b"TSRTILE1":
        raise unsound("bad magic number, or too few bytes for the header")
    x0, y0, x1, y1, begin, end, channel_count = struct.unpack_from("<7I", payload, 8)
    if x1 <= x0 or y1 <= y0 or end <= begin:
        raise unsound("its rectangle or its sample range is empty")
    if not 0 < channel_count <= _MAX_CHANNELS:
        raise unsound(f"{channel_count} channels; 1 to {_MAX_CHANNELS} were expected")
    pixels = (x1 - x0) * (y1 - y0)
    if pixels > _MAX_PIXELS:
        raise unsound(f"{pixels} pixels, where at most {_MAX_PIXELS} were expected")
    at, channels = 36, []
    for _ in range(channel_count):
        if len(payload) < at + 3 or len(payload) < at + 3 + payload[at + 2]:
            raise unsound("the header ends within its channels")
        kind, of, length = payload[at : at + 3]
        name = payload[at + 3 : at + 3 + length].decode("utf-8", "replace")
        channels.append(Channel(name, kind, of))
        at += 3 + length
    for channel in channels:
        if channel.kind not in (_SUM, _SQUARED_DEVIATION, _FIRST):
            raise unsound(f'channel "{channel.name}" is of an unknown kind')
        if channel.kind == _SQUARED_DEVIATION:
            if channel.of >= channel_count or channels[channel.of].kind != _SUM:
                raise unsound(f'channel "{channel.name}" belongs to no sum')
    words = pixels * (1 + channel_count)
    try:
        if zstandard.frame_content_size(payload[at:]) != at + 4 * words:
            raise unsound("the compressed part does not have the size of its channels")
        content = zstandard.ZstdDecompressor().decompress(payload[at:])
    except zstandard.ZstdError as error:
        raise unsound(f"the compressed part is damaged: {error}") from error
    if len(content) != at + 4 * words or content[:at] != payload[:at]:
        raise unsound("the header is damaged")
    planes = np.frombuffer(content, np.uint8, offset=at).reshape(4, words)
    joined = np.ascontiguousarray(planes.T).view("<u4").reshape(words)
    shape = (y1 - y0, x1 - x0)
    return TileResult(
        Rect(x0, y0, x1, y1),
        begin,
        end,
        tuple(channels),
        joined[:pixels].reshape(shape).astype(np.uint32),
        joined[pixels:].view("<f4").reshape((channel_count, *shape)).astype(np.float32),
    )


def merge(left: TileResult, right: TileResult) -> TileResult:
    """The node of which these two are the children [proto/wire/merge_pixel_nodes.cpp]."""
    values = np.empty_like(left.values)
    n_left, n_right = left.counts.astype(np.float64), right.counts.astype(np.float64)
    both = (left.counts != 0) & (right.counts != 0)
    for c, channel in enumerate(left.channels):
        a, b = left.values[c], right.values[c]
        if channel.kind == _SUM:
            values[c] = a + b
        elif channel.kind == _FIRST:
            values[c] = np.where(left.counts == 0, b, a)
        else:
            # Chan et al. 1979, eq. 2.1, in double, rounded once.
            between = np.zeros(a.shape)
            nl, nr = n_left[both], n_right[both]
            sums_left = left.values[channel.of][both].astype(np.float64)
            sums_right = right.values[channel.of][both].astype(np.float64)
            difference = sums_right / nr - sums_left / nl
            between[both] = difference * difference * (nl * nr / (nl + nr))
            values[c] = ((a.astype(np.float64) + b.astype(np.float64)) + between).astype(np.float32)
    return TileResult(
        left.pixels, left.begin, right.end, left.channels, left.counts + right.counts, values
    )


def pixel_values(node: TileResult) -> Floats:
    """The values of a node's pixels, (channels, height, width): means over samples, and variances."""
    values = np.empty_like(node.values)
    counts = node.counts.astype(np.int64)
    for c, channel in enumerate(node.channels):
        if channel.kind == _FIRST:
            values[c] = node.values[c]
            continue
        divisor = counts if channel.kind == _SUM else np.maximum(counts, 1) - 1
        quotient = np.divide(
            node.values[c].astype(np.float64),
            divisor,
            out=np.zeros(divisor.shape),
            where=divisor != 0,
        )
        values[c] = quotient.astype(np.float32)
    return values


def _centre_of(name: str) -> float:
    """550.0 of "S0.550,000000nm" [Fichet, Pacanowski & Wilkie 2021]."""
    return float(name[len("S0.") : -len("nm")].replace(",", "."))


def _band_names(channels: Iterable[str]) -> list[str]:
    return sorted((name for name in channels if name.startswith("S0.")), key=_centre_of)


@dataclass
class Picture:
    """The picture that a job has rendered. `channels` has planes of `data.height` rows, from the top, and `data.width`
    columns; "R", "G" and "B" are linear Rec.709, unless the job's sensor and rgb_space say otherwise."""

    data: Rect  # the pixels that are there; a crop is smaller than the film
    display: Rect  # the whole film
    channels: dict[str, Floats] = field(default_factory=dict)
    missing: npt.NDArray[np.bool_] | None = None  # pixels without all of their samples; None: there are none

    @property
    def rgb(self) -> Floats:
        """(height, width, 3)"""
        return np.stack([self.channels[name] for name in "RGB"], axis=-1)

    @property
    def rgba(self) -> Floats:
        """(height, width, 4)"""
        return np.stack([self.channels[name] for name in "RGBA"], axis=-1)

    @property
    def bands(self) -> Floats:
        """Spectral radiance per nanometre, (height, width, N), in the order of `band_centres`; N is 0 where the
        film has no bands."""
        planes = [self.channels[name] for name in _band_names(self.channels)]
        return np.stack(planes, axis=-1) if planes else np.zeros((self.data.height, self.data.width, 0), np.float32)

    @property
    def band_centres(self) -> npt.NDArray[np.float64]:
        """Wavelengths in the middle of the bands, (N,), ascending, in nanometres."""
        return np.array([_centre_of(name) for name in _band_names(self.channels)], np.float64)

    def __getitem__(self, name: str) -> Floats:
        """A channel, or the channels of a layer, (height, width, n): "albedo" for albedo.R, albedo.G,
        albedo.B."""
        if name in self.channels:
            return self.channels[name]
        bands = [plane for key, plane in self.channels.items() if key.startswith(name + ".")]
        if not bands:
            raise KeyError(f"there is no channel {name}; there are {', '.join(self.channels)}")
        return np.stack(bands, axis=-1)


def _are_siblings(a_begin: int, a_end: int, b_begin: int, b_end: int, spp: int) -> bool:
    length = a_end - a_begin
    if length <= 0 or b_end <= b_begin or b_begin != a_end:
        return False
    if length & (length - 1) or a_begin % (2 * length):
        return False
    return b_end == min(a_begin + 2 * length, spp)


class Assembler:
    """Puts the results of one job together, in any order."""

    def __init__(self, spec: job_pb2.JobSpec) -> None:
        crop = spec.cut.crop
        self._spp = spec.samples.spp
        self._samples_channel = job_pb2.AOV_SAMPLES in spec.view.aovs
        self._data = Rect(crop.x0, crop.y0, crop.x1, crop.y1)
        self._display = Rect(0, 0, spec.view.width, spec.view.height)
        self._channels: tuple[Channel, ...] | None = None
        self._nodes: dict[Rect, dict[int, TileResult]] = {}
        self._owner = np.zeros((self._data.height, self._data.width), np.uint32)
        self.samples_done = 0

    @property
    def samples_total(self) -> int:
        return self._data.width * self._data.height * self._spp

    def add(self, result: TileResult) -> TileResult:
        """Takes one result; returns the largest node that it is part of now."""
        where = f"result for pixels {result.pixels}, samples [{result.begin}, {result.end})"
        if not self._data.contains(result.pixels):
            raise TesseraError(f"{where}: not inside the part of the film that is rendered")
        size = 1 << (result.end - result.begin - 1).bit_length()
        whole = result.begin + size == result.end or result.end == self._spp
        if result.end > self._spp or result.begin % size or not whole:
            raise TesseraError(f"{where}: not a node of the sum tree over {self._spp} samples")
        if self._channels is None:
            self._channels = result.channels
        if result.channels != self._channels:
            raise TesseraError(f"{where}: has other channels than the results before")
        if (result.counts > result.end - result.begin).any():
            raise TesseraError(f"{where}: a pixel has more samples than the range")
        nodes = self._tile(result, where)
        for other in nodes.values():
            if other.begin < result.end and result.begin < other.end:
                raise TesseraError(f"{where}: there already")
        self.samples_done += result.counts.size * (result.end - result.begin)
        merged = self._merge_siblings(nodes, result)
        nodes[merged.begin] = merged
        return merged

    def _tile(self, result: TileResult, where: str) -> dict[int, TileResult]:
        nodes = self._nodes.get(result.pixels)
        if nodes is None:
            owner = self._owner[self._slices(result.pixels)]
            if owner.any():
                raise TesseraError(f"{where}: its pixels overlap those of another tile")
            owner[:] = 1
            nodes = self._nodes[result.pixels] = {}
        return nodes

    def _merge_siblings(self, nodes: dict[int, TileResult], result: TileResult) -> TileResult:
        while True:
            right = nodes.get(result.end)
            left = next((node for node in nodes.values() if node.end == result.begin), None)
            if right and _are_siblings(result.begin, result.end, right.begin, right.end, self._spp):
                del nodes[right.begin]
                result = merge(result, right)
            elif left and _are_siblings(left.begin, left.end, result.begin, result.end, self._spp):
                del nodes[left.begin]
                result = merge(left, result)
            else:
                return result

    def _slices(self, pixels: Rect) -> tuple[slice, slice]:
        return (
            slice(pixels.y0 - self._data.y0, pixels.y1 - self._data.y0),
            slice(pixels.x0 - self._data.x0, pixels.x1 - self._data.x0),
        )

    def picture(self) -> Picture:
        """The picture so far. A pixel that lacks samples is the mean of those it has; one that has none is 0
        in all channels, and both are `missing`."""
        names = [channel.name for channel in self._channels or ()]
        shape = (self._data.height, self._data.width)
        picture = Picture(
            self._data, self._display, {name: np.zeros(shape, np.float32) for name in names}
        )
        samples = np.zeros(shape, np.float32)
        missing = np.ones(shape, np.bool_)
        for pixels, nodes in self._nodes.items():
            parts = [nodes[begin] for begin in sorted(nodes)]
            sums = parts[0]
            for part in parts[1:]:
                sums = merge(sums, part)
            where = self._slices(pixels)
            for name, plane in zip(names, pixel_values(sums)):
                picture.channels[name][where] = plane
            samples[where] = sums.counts.astype(np.float32)
            missing[where] = len(parts) != 1 or sums.begin != 0 or sums.end != self._spp
        if self._samples_channel:
            picture.channels["samples"] = samples
        picture.missing = missing if missing.any() else None
        return picture
