#!/usr/bin/env python3
"""Writes scene.textproto beside it: two paints that look the same in daylight, and two booths to see them in.

The second paint is the first plus a metameric black [Wyszecki and Stiles 2000]: a function of the wavelength that
daylight (D65) makes nothing of for the CIE 1931 observer. The tables are those of lib/spectra.
"""
import pathlib
import re

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
NM = numpy.arange(360, 831, 5)


def numbers(path, name):
    text = (ROOT / "lib/spectra" / path).read_text()
    body = text[text.index("= {", text.index(name)):]
    body = re.sub(r"//[^\n]*", "", body[:body.index(";")])
    return numpy.array([float(v) for v in re.findall(r"-?\d+\.?\d*(?:[eE]-?\d+)?", body)])


observer = numbers("observer/cie1931.h", "kCie1931").reshape(-1, 3)
daylight = numpy.interp(NM, numpy.arange(300, 831, 10), numbers("light/daylight.h", "> kD65"))
seen = (observer * daylight[:, None]).T  # 3 x 95: XYZ of a reflectance in daylight

lamp = numbers("light/fluorescent.cpp", "kF11")  # 380 to 780 nm, of three bands
lamp_nm = numpy.arange(380, 781, 5)
first = 0.44 + 0.1 * numpy.tanh((NM - 560) / 40)
wave = numpy.where((NM > 420) & (NM < 680), numpy.cos(2 * numpy.pi * (NM - 550) / 95), 0)
black = wave - seen.T @ numpy.linalg.solve(seen @ seen.T, seen @ wave)
second = first + 0.28 * black / numpy.abs(black).max()
assert 0 < second.min() and second.max() < 1
assert numpy.abs(seen @ (second - first)).max() < 1e-9 * numpy.abs(seen @ first).max()


def sampled(values, wavelengths=NM):
    nm = ", ".join(f"{v:g}" for v in wavelengths)
    return f"sampled {{ wavelengths_nm: [{nm}]\n      values: [{', '.join(f'{v:.5f}' for v in values)}] }}"


def booth(name, x, radiance):
    return f"""
# The booth on the {name}
shapes {{ box {{ low: [{x - 1:g}, -0.1, -1.6] high: [{x + 1:g}, 0, 1.6] }} material: "grey" }}
shapes {{ box {{ low: [{x - 1:g}, 0, 1.5] high: [{x + 1:g}, 2.2, 1.6] }} material: "grey" }}
shapes {{ sphere {{ radius: 0.45 }} material: "first paint"
  world_from_object {{ elements: [1, 0, 0, {x - 0.46:g},  0, 1, 0, 0.45,  0, 0, 1, 0.3,  0, 0, 0, 1] }} }}
shapes {{ sphere {{ radius: 0.45 }} material: "second paint"
  world_from_object {{ elements: [1, 0, 0, {x + 0.46:g},  0, 1, 0, 0.45,  0, 0, 1, 0.3,  0, 0, 0, 1] }} }}
shapes {{ disk {{ radius: 0.5 }} area_light {{ {radiance} }}
  world_from_object {{ elements: [1, 0, 0, {x:g},  0, 0, -1, 2.1,  0, 1, 0, -0.3,  0, 0, 0, 1] }} }}"""


scene = f"""# proto-file: proto/tessera/v1/scene.proto
# proto-message: tessera.v1.Scene
#
# Two paints that are one in daylight (left) and two under a fluorescent lamp (right); written by make_scene.py. RGB sees
# one paint in both.
name: "metamers"
materials {{ name: "grey" diffuse {{ reflectance {{ constant {{ constant: 0.5 }} }} }} }}
materials {{ name: "black" diffuse {{ reflectance {{ constant {{ constant: 0 }} }} }} }}
materials {{ name: "first paint" diffuse {{ reflectance {{ constant {{ {sampled(first)} }} }} }} }}
materials {{ name: "second paint" diffuse {{ reflectance {{ constant {{ {sampled(second)} }} }} }} }}
{booth("left: daylight", -1.03, "radiance { constant: 9 }")}
{booth("right: fluorescent lamp F11", 1.03, "radiance { " + sampled(lamp / 20, lamp_nm) + " } scale: 16")}

shapes {{ name: "wall between" box {{ low: [-0.03, -0.1, -1.6] high: [0.03, 2.3, 1.6] }} material: "black" }}

camera {{
  perspective {{ fov_degrees: 18 }}
  world_from_camera {{ elements: [1, 0, 0, 0,  0, 0.985, -0.1736, 2.1,  0, 0.1736, 0.985, -7.4,  0, 0, 0, 1] }}
}}
film {{ width: 720 height: 360 filter {{ kind: GAUSSIAN }} }}
settings {{ integrator: "path" spp: 64 max_depth: 6 color: COLOR_SPECTRAL }}
"""
pathlib.Path(__file__).with_name("scene.textproto").write_text(scene)
