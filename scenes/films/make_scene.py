#!/usr/bin/env python3
"""Writes films.gltf: rows of spheres with thin films from 0 to 1000 nm, over a dielectric and over a metal, and
balls of glass whose dispersion grows, before a wall with white stripes."""

import base64
import json
import math
import pathlib
import struct

COLUMNS, ROWS = 48, 24  # of a sphere
STEPS = 11


def sphere():
    """Positions on the unit sphere, and triangles that are seen from outside."""
    points, triangles = [], []
    for row in range(ROWS + 1):
        theta = math.pi * row / ROWS
        for column in range(COLUMNS + 1):
            phi = 2 * math.pi * column / COLUMNS
            points.append((math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi)))
    for row in range(ROWS):
        for column in range(COLUMNS):
            a = row * (COLUMNS + 1) + column
            b = a + COLUMNS + 1
            if row > 0:
                triangles += [(a, b, a + 1)]
            if row < ROWS - 1:
                triangles += [(a + 1, b, b + 1)]
    return points, triangles


def main():
    data, views, accessors = b"", [], []

    def put(rows, code, component, kind, target, bounds=False):
        nonlocal data
        data += b"\0" * (-len(data) % 4)
        blob = b"".join(struct.pack("<" + code * len(row), *row) for row in rows)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(blob), "target": target})
        width = {"SCALAR": 1, "VEC3": 3}[kind]
        accessor = {"bufferView": len(views) - 1, "componentType": component,
                    "count": len(rows) * len(rows[0]) // width, "type": kind}
        if bounds:
            single = [struct.unpack("<fff", struct.pack("<fff", *row)) for row in rows]
            accessor["min"] = [min(column) for column in zip(*single)]
            accessor["max"] = [max(column) for column in zip(*single)]
        accessors.append(accessor)
        data += blob
        return len(accessors) - 1

    points, triangles = sphere()
    ball = {"POSITION": put(points, "f", 5126, "VEC3", 34962, True)}
    views[0]["byteStride"] = 12  # for both positions and normals
    accessors.append({"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"})
    ball["NORMAL"] = len(accessors) - 1
    ball_indices = put(triangles, "H", 5123, "SCALAR", 34963)
    corners = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
    quad = {"POSITION": put(corners, "f", 5126, "VEC3", 34962, True)}
    quad_indices = put([(0, 1, 2), (0, 2, 3)], "H", 5123, "SCALAR", 34963)

    materials, meshes, nodes = [], [], []

    def shape(attributes, indices, material, place, scale):
        materials.append(material)
        meshes.append({"primitives": [{"attributes": attributes, "indices": indices,
                                       "material": len(materials) - 1}]})
        nodes.append({"mesh": len(meshes) - 1, "translation": place, "scale": scale})

    def paint(name, color, metallic, roughness, **extensions):
        material = {"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": color + [1], "metallicFactor": metallic, "roughnessFactor": roughness}}
        if extensions:
            material["extensions"] = {"KHR_materials_" + key: value for key, value in extensions.items()}
        return material

    for i in range(STEPS):
        nm = 1000 * i / (STEPS - 1)
        x = 2.2 * (i - (STEPS - 1) / 2)
        film = {"iridescenceFactor": 1, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": nm}
        shape(ball, ball_indices, paint(f"dielectric, {nm:.0f} nm", [0.02, 0.02, 0.02], 0, 0.12, iridescence=film),
              [x, 2.4, 0], [1, 1, 1])
        shape(ball, ball_indices, paint(f"metal, {nm:.0f} nm", [0.6, 0.6, 0.6], 1, 0.2, iridescence=film),
              [x, 0, 0], [1, 1, 1])
    for i, dispersion in enumerate([0, 0.36, 1, 3, 8]):  # Abbe numbers: without end, 55, 20, 7, 2.5
        glass = paint(f"glass, dispersion {dispersion}", [1, 1, 1], 0, 0, transmission={"transmissionFactor": 1},
                      volume={"thicknessFactor": 2}, ior={"ior": 1.6}, dispersion={"dispersion": dispersion})
        shape(ball, ball_indices, glass, [4.4 * (i - 2), -3.2, 0], [1.7, 1.7, 1.7])
    shape(quad, quad_indices, paint("wall", [0.03, 0.03, 0.03], 0, 1), [0, 0, -4], [40, 40, 1])
    stripe = paint("stripe", [0.9, 0.9, 0.9], 0, 1)
    for i in range(-12, 13):
        shape(quad, quad_indices, stripe, [1.1 * i, -3.2, -3.9], [0.12, 1.9, 1])

    nodes.append({"camera": 0, "translation": [0, -0.4, 34]})
    extensions = ["dispersion", "ior", "iridescence", "transmission", "volume"]
    document = {
        "asset": {"version": "2.0", "generator": "make_scene.py"},
        "extensionsUsed": ["KHR_materials_" + name for name in extensions],
        "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.36, "aspectRatio": 2, "znear": 0.1}}],
        "meshes": meshes, "materials": materials, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                     base64.b64encode(data).decode()}]}
    pathlib.Path(__file__).with_name("films.gltf").write_text(json.dumps(document, indent=1) + "\n")


main()
