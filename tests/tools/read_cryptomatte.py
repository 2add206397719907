#!/usr/bin/env python3
"""Reads the Cryptomattes of an EXR by the published specification (version 1.2) alone.

Needs NumPy and OpenImageIO's Python module (Debian: python3-numpy python3-openimageio).

    read_cryptomatte.py FILE.exr                a table: name of the matte, of the thing, its area in pixels
    read_cryptomatte.py FILE.exr --check        the same, and exit code 1 where the file breaks a rule
"""
import argparse
import json
import struct
import sys

import numpy
import OpenImageIO as oiio


def murmur3(data: bytes, seed: int = 0) -> int:
    """MurmurHash3_x86_32."""
    mask = 0xFFFFFFFF
    h = seed
    for i in range(0, len(data) & ~3, 4):
        k = struct.unpack_from("<I", data, i)[0] * 0xCC9E2D51 & mask
        k = (k << 15 | k >> 17) & mask
        h ^= k * 0x1B873593 & mask
        h = (h << 13 | h >> 19) & mask
        h = (h * 5 + 0xE6546B64) & mask
    k = int.from_bytes(data[len(data) & ~3:], "little")
    if k:
        k = k * 0xCC9E2D51 & mask
        k = (k << 15 | k >> 17) & mask
        h ^= k * 0x1B873593 & mask
    h ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        h = (h ^ h >> shift) * factor & mask
    return h


def identifier(name: str) -> int:
    """Bits of the float that stands for a name."""
    bits = murmur3(name.encode())
    if bits >> 23 & 255 in (0, 255):
        bits ^= 1 << 23
    return bits


def read_channels(path: str) -> tuple[dict[str, numpy.ndarray], dict[str, str]]:
    """Planes of all parts by name, and the attributes of the first."""
    planes, attributes = {}, {}
    file = oiio.ImageInput.open(path)
    part = 0
    while file.seek_subimage(part, 0):
        spec = file.spec()
        pixels = file.read_image(part, 0, 0, spec.nchannels, "float")
        if pixels is None:
            raise SystemExit(f"{path}: part {part} cannot be read: {file.geterror()}")
        pixels = pixels.reshape(spec.height, spec.width, spec.nchannels)
        for i, name in enumerate(spec.channelnames):
            # OpenImageIO puts the part's name before names that do not begin with it.
            planes.setdefault(name, pixels[:, :, i])
        if part == 0:
            attributes = {a.name: a.value for a in spec.extra_attribs}
        part += 1
    return planes, attributes


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    planes, attributes = read_channels(options.file)
    faults = []
    keys = sorted({a.split("/")[1] for a in attributes if a.startswith("cryptomatte/")})
    if not keys:
        faults.append("there is no Cryptomatte")
    for key in keys:
        facts = {a.split("/")[2]: v for a, v in attributes.items() if a.startswith(f"cryptomatte/{key}/")}
        name = facts["name"]
        if facts.get("hash") != "MurmurHash3_32" or facts.get("conversion") != "uint32_to_float32":
            faults.append(f"{name}: unknown hash or conversion")
        manifest = json.loads(facts["manifest"])
        for thing, text in manifest.items():
            if int(text, 16) != identifier(thing):
                faults.append(f"{name}: the manifest calls {thing} {text}, not {identifier(thing):08x}")
        ranks = []
        for layer in range(100):
            bands = [next((planes[f"{name}{layer:02d}.{b}"] for b in (band, band.lower())
                           if f"{name}{layer:02d}.{b}" in planes), None) for band in "RGBA"]
            if bands[0] is None:
                break
            ranks += [(bands[0], bands[1]), (bands[2], bands[3])]
        if not ranks:
            faults.append(f"{name}: no channels")
            continue
        total = numpy.zeros(ranks[0][0].shape)
        known = {int(text, 16) for text in manifest.values()}
        areas = dict.fromkeys(manifest, 0.0)
        before = None
        for identifiers, coverage in ranks:
            bits = numpy.ascontiguousarray(identifiers, dtype=numpy.float32).view(numpy.uint32)
            strangers = set(numpy.unique(bits[coverage > 0]).tolist()) - known
            if strangers:
                faults.append(f"{name}: {len(strangers)} identifiers are not in the manifest")
            if (coverage < 0).any() or (before is not None and (coverage > before).any()):
                faults.append(f"{name}: coverages do not descend")
            before = coverage
            total += coverage
            for thing, text in manifest.items():
                areas[thing] += float(coverage[bits == int(text, 16)].sum(dtype=numpy.float64))
        if total.max() > 1 + 1e-4:
            faults.append(f"{name}: coverages add up to {total.max()}")
        for thing, area in sorted(areas.items()):
            print(f"{name}\t{thing}\t{area:.3f}")
        print(f"{name}\t(all)\t{total.sum():.3f}\tleast {total.min():.6f}\tmost {total.max():.6f}")
    for fault in faults:
        print(fault, file=sys.stderr)
    return 1 if options.check and faults else 0


if __name__ == "__main__":
    sys.exit(main())
