#!/usr/bin/env python3
"""Writes scene.textproto beside it: a box of lamps behind a mask, through six pinholes, 100 mm before the film.

The mask has a star of 24 sectors, bars, and a point. Every view is one hole; the sharpest is about 0.4 mm wide.
"""
import math
import pathlib

HOLES = (2, 1, 0.6, 0.35, 0.15, 0.07)  # mm
DISTANCE = 2  # metres


def polygon(corners, radiance=1):
    points = ", ".join(f"{x:.6g}, {y:.6g}, {DISTANCE}" for x, y in corners)
    return (
        f"shapes {{ polygon {{ corners: [{points}] }}\n"
        f"         area_light {{ two_sided: true radiance {{ constant: {radiance:g} }} }} }}\n"
    )


def bar(x0, y0, x1, y1):
    return polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def camera(field, hole):
    return (
        f"{field} {{ pinhole {{ hole_mm: {hole:g} film_distance_mm: 100 film_gauge: \"full-frame\"\n"
        f"  scene_distance: {DISTANCE} }} }}\n"
    )


parts = [
    "# proto-file: proto/tessera/v1/scene.proto\n"
    "# proto-message: tessera.v1.Scene\n"
    "#\n"
    "# Written by make_scene.py: a mask before a box of lamps, through pinholes of 2, 1, 0.6, 0.35, 0.15 and 0.07 mm. Metres.\n"
    'name: "pinhole-series"\n'
]
parts += [camera("camera" if i == 0 else "views", hole) for i, hole in enumerate(HOLES)]
parts.append(
    "film { width: 320 height: 320 }\n"
    'settings { integrator: "path" color: COLOR_SPECTRAL spp: 1024 max_depth: 0 }\n'
)
for i in range(12):  # the star
    a, b = (2 * math.pi * (i + part) / 12 for part in (0, 0.5))
    middle = (-0.06, 0.05)
    corners = [middle] + [
        (middle[0] + 0.14 * math.cos(a + (b - a) * k / 4), middle[1] + 0.14 * math.sin(a + (b - a) * k / 4))
        for k in range(5)
    ]
    parts.append(polygon(corners))
x = -0.2
for width in (0.016, 0.011, 0.0075, 0.005):  # on the film, 1/20 of it
    for i in range(4):
        parts.append(bar(x, -0.2, x + width, -0.125))
        x += 2 * width
    x += 0.02
parts.append(bar(0.12, 0.05, 0.2, 0.055))
parts.append(bar(0.157, 0.013, 0.162, 0.093))
corners = [(0.16 + 0.004 * math.cos(math.pi * k / 6), 0.16 + 0.004 * math.sin(math.pi * k / 6)) for k in range(12)]
parts.append(polygon(corners, 10))
(pathlib.Path(__file__).parent / "scene.textproto").write_text("".join(parts))
