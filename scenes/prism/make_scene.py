#!/usr/bin/env python3
"""Writes scene.textproto beside it: light of a lamp that a slit lets to a prism of heavy flint, which throws its
spectrum on a wall. The prism is turned so that light of 560 nm passes it evenly, where it is turned least.
"""
import math
import pathlib

INDEX = 1.7906  # of N-SF11 at 560 nm
SIDE, BOTTOM, TOP = 0.5, 0.001, 0.55
HEADING = 6  # of the light before the prism, in degrees from +x towards +z

turn = 2 * math.degrees(math.asin(INDEX / 2)) - 60
base = HEADING + turn / 2 + 90  # heading of the base's normal, on the side that light is turned to
inner = SIDE / math.sqrt(12)


def along(degrees, length=1):
    return length * math.cos(math.radians(degrees)), length * math.sin(math.radians(degrees))


def numbers(values):
    return ", ".join(f"{v:.9g}" for v in values)


def placed(heading, x, y, z):
    """From a frame whose x axis has this heading, at (x, y, z)."""
    c, s = along(heading)
    return f"world_from_object {{ elements: [{numbers([c, 0, -s, x, 0, 1, 0, y, s, 0, c, z, 0, 0, 0, 1])}] }}"


planes = [0, -1, 0, -BOTTOM, 0, 1, 0, TOP]
for k in range(3):
    x, z = along(base + 120 * k)
    planes += [x, 0, z, inner]

meets = along(base + 120, inner)  # the middle of the face that light meets
lamp = [meets[i] - 3 * along(HEADING)[i] for i in range(2)]
slit = [meets[i] - 0.55 * along(HEADING)[i] for i in range(2)]


def camera(eye, target):
    z = [t - e for e, t in zip(eye, target)]
    length = math.hypot(*z)
    z = [v / length for v in z]
    x = [z[2], 0, -z[0]]
    length = math.hypot(*x)
    x = [v / length for v in x]
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    rows = [(x[i], y[i], z[i], eye[i]) for i in range(3)]
    return numbers([v for row in rows for v in row] + [0, 0, 0, 1])


scene = f"""# proto-file: proto/tessera/v1/scene.proto
# proto-message: tessera.v1.Scene
#
# A prism of heavy flint throws the spectrum of a lamp behind a slit on a wall; written by make_scene.py.
name: "prism"
materials {{ name: "paper" diffuse {{ reflectance {{ constant {{ constant: 0.7 }} }} }} }}
materials {{ name: "black" diffuse {{ reflectance {{ constant {{ constant: 0.02 }} }} }} }}
materials {{ name: "flint" dielectric {{ dispersion {{ glass: "N-SF11" }} }} }}

shapes {{ name: "table" box {{ low: [-4, -0.1, -4] high: [4, 0, 2.2] }} material: "paper" }}
shapes {{ name: "wall" box {{ low: [-4, 0, 2.2] high: [4, 4, 2.3] }} material: "paper" }}
shapes {{ name: "prism" material: "flint" polyhedron {{
  planes: [{numbers(planes)}] }} }}
shapes {{ name: "slit, one side" box {{ low: [-0.01, 0, 0.01] high: [0.01, 0.6, 0.4] }} material: "black"
  {placed(HEADING, slit[0], 0, slit[1])} }}
shapes {{ name: "slit, other side" box {{ low: [-0.01, 0, -0.4] high: [0.01, 0.6, -0.01] }} material: "black"
  {placed(HEADING, slit[0], 0, slit[1])} }}

lights {{ spot {{
  position {{ x: {lamp[0]:.5g} y: 0.3 z: {lamp[1]:.5g} }} target {{ x: {meets[0]:.5g} y: 0.3 z: {meets[1]:.5g} }}
  intensity {{ constant: 2000 }} cone_angle_degrees: 4.6 cone_delta_degrees: 0.3 }} }}
lights {{ infinite {{ radiance {{ constant: 0.12 }} }} }}

camera {{
  perspective {{ fov_degrees: 36 }}
  world_from_camera {{ elements: [{camera((0.5, 1.15, -2.3), (0.22, 0.36, 0.7))}] }}
}}
film {{ width: 720 height: 400 filter {{ kind: GAUSSIAN }} }}
settings {{ integrator: "bdpt" spp: 64 max_depth: 8 color: COLOR_SPECTRAL }}
"""
pathlib.Path(__file__).with_name("scene.textproto").write_text(scene)
