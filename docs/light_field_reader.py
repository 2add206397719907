#!/usr/bin/python3
"""Reads light fields (docs/light-field.md) with numpy and Python's own library: no Tessera, no OpenEXR.

light_field_reader.py SET VIEW X Y prints a pixel's channels and its ray.
"""
import hashlib, json, pathlib, sys, zlib

import numpy as np


class LightField:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        m = self.manifest = json.loads((self.folder / "manifest.json").read_text())
        if (m["format"], m["version"]) != ("tessera light field", 1):
            raise ValueError(f"this reader is for version 1, not {m['version']}")
        if m["compression"] not in ("none", "zip"):
            raise ValueError(f"compression {m['compression']}: that needs OpenEXR")

    def tile(self, view, x, y):
        """Arrays of a tile by channel: A, B, G, R, depth.Z. x and y count tiles from the upper left one."""
        m, v, size = self.manifest, self.manifest["views"][view], self.manifest["tile_size"]
        offset, length, digest = v["tiles"][y * -(-m["width"] // size) + x]
        with open(self.folder / "data" / (v["file"] + ".exr"), "rb") as file:
            file.seek(offset)  # over HTTP: Range: bytes=offset-(offset + length - 1)
            data = np.frombuffer(file.read(length), np.uint8)
        if hashlib.sha256(data).hexdigest()[:16] != digest:
            raise ValueError(f"view {view}, tile {x},{y} is damaged")
        width, height = min(size, m["width"] - x * size), min(size, m["height"] - y * size)
        types = {c["name"]: np.dtype("<f2" if c["type"] == "half" else "<f4") for c in m["channels"]}
        if length < width * height * sum(t.itemsize for t in types.values()):  # ZIP of OpenEXR
            data = np.frombuffer(zlib.decompress(data), np.uint8).astype(np.int64)
            data = (np.cumsum(data - 128) + 128).astype(np.uint8)  # differences of neighbours
            halves, half = data, (len(data) + 1) // 2  # bytes of even places, then those of odd ones
            data = np.empty_like(halves)
            data[0::2], data[1::2] = halves[:half], halves[half:]
        rows, planes, begin = data.reshape(height, -1), {}, 0
        for name, kind in types.items():  # each row: all of A, all of B, ...
            end = begin + width * kind.itemsize
            planes[name] = np.ascontiguousarray(rows[:, begin:end]).view(kind).astype(np.float32)
            begin = end
        return planes

    def ray(self, view, x, y):
        """Origin and direction (unit) in world space of the light at a place: the first pixel is (0.5, 0.5)."""
        v = self.manifest["views"][view]
        matrix, (fx, fy, cx, cy) = np.reshape(v["world_from_camera"], (4, 4)), v["intrinsics"]
        direction = matrix[:3, :3] @ np.array([(x - cx) / fx, (cy - y) / fy, 1])
        return matrix[:3, 3], direction / np.linalg.norm(direction)


if __name__ == "__main__":
    field, (number, column, row) = LightField(sys.argv[1]), map(int, sys.argv[2:5])
    side = field.manifest["tile_size"]
    tile = field.tile(number, column // side, row // side)
    print(*(repr(float(plane[row % side, column % side])) for plane in tile.values()))
    print(*(float(n) for vector in field.ray(number, column + 0.5, row + 0.5) for n in vector))
