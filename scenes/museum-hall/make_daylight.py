#!/usr/bin/env python3
"""The hall of scene.textproto by daylight: its skylight open, under a sky of a place and a time.

    scenes/museum-hall/make_daylight.py                       writes daylight.textproto beside it
    scenes/museum-hall/make_daylight.py --weather year.epw    a weather file of a year without a cloud

The weather file is synthetic: no station has measured it. Direct light is that of a clear atmosphere [Meinel 1976],
diffuse light follows from it [Liu 1960].
"""
from __future__ import annotations

import argparse
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
LATITUDE, LONGITUDE, UTC_OFFSET = 48.14, 11.58, 1.0  # Munich, by winter time
DAYS = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]

HEAD = """# proto-file: proto/tessera/v1/scene.proto
# proto-message: tessera.v1.Scene
#
# The hall of scene.textproto by daylight; written by make_daylight.py. World space is right-handed, as that of skies
# is: x left, y up, z away from the camera, which is north; metres.
name: "museum-hall-daylight"
units { metres: 1 }
"""

# The camera of scene.textproto with x to the left, as right-handed axes have it.
CAMERA = """camera {
  perspective { fov_degrees: 55 }
  world_from_camera {
    elements: [-0.99579, -0.0018022, 0.091699, -0.6,  0, 0.99981, 0.01965, 1.6,
        0.091717, -0.019567, 0.99559, 0.4,  0, 0, 0, 1]
  }
}
film { width: 480 height: 320 filter { kind: GAUSSIAN } photographic_exposure { ev100: 7 cd_per_m2: 683 } }
settings { integrator: "path" spp: 256 max_depth: 24 }
"""


def sun_altitude(day_of_year: int, hour: float) -> float:
    """Degrees, to one or so: enough to tell day from night."""
    angle = 2 * math.pi * (day_of_year - 81) / 365
    declination = math.radians(23.44) * math.sin(angle)
    equation = 9.87 * math.sin(2 * angle) - 7.53 * math.cos(angle) - 1.5 * math.sin(angle)  # minutes
    solar = hour + (LONGITUDE - 15 * UTC_OFFSET) / 15 + equation / 60
    turn = math.radians(15 * (solar - 12))
    latitude = math.radians(LATITUDE)
    up = math.sin(latitude) * math.sin(declination) + math.cos(latitude) * math.cos(declination) * math.cos(turn)
    return math.degrees(math.asin(up))


def day_of_year(month: int, day: int) -> int:
    return sum(DAYS[: month - 1]) + day


def sky(cie_type: int, month: int, day: int, hour: float) -> str:
    return f"""lights {{
  name: "daylight"
  sky {{
    when {{ latitude_degrees: {LATITUDE} longitude_degrees: {LONGITUDE} utc_offset_hours: {UTC_OFFSET:g}
      year: 2024 month: {month} day: {day} hour: {hour:g} }}
    cie_type: {cie_type}
    north_degrees: 180
    y_up: true
    sky_color {{ blackbody {{ kelvin: 9000 }} }}
    sun_color {{ blackbody {{ kelvin: 5500 }} }}
  }}
}}
"""


def hall(light: str) -> str:
    lines = (HERE / "scene.textproto").read_text().splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if line.startswith("materials"))
    last = next(i for i, line in enumerate(lines) if line.startswith("camera"))
    kept, inside = [], False
    for line in lines[first:last]:
        # The lamp in the place of the sky, and its matrix.
        if "area_light" in line:
            inside = True
        if not inside:
            kept.append(line)
        if "world_from_object" in line:
            inside = False
    return HEAD + light + "\n" + "".join(kept) + CAMERA


def clear_sky(altitude: float) -> tuple[float, float]:
    """Direct normal and diffuse horizontal irradiance, W/m^2."""
    if altitude <= 0:
        return 0, 0
    sine = math.sin(math.radians(altitude))
    air_mass = 1 / (sine + 0.50572 * (altitude + 6.07995) ** -1.6364)
    direct = 0.7 ** (air_mass**0.678)  # over extraterrestrial
    return 1367 * direct, 1367 * sine * (0.271 - 0.294 * direct)


def write_weather(path: pathlib.Path) -> None:
    lines = [
        f"LOCATION,Munich without clouds,-,XXX,synthetic clear sky,000000,{LATITUDE},{LONGITUDE},{UTC_OFFSET},520.0",
        "DESIGN CONDITIONS,0",
        "TYPICAL/EXTREME PERIODS,0",
        "GROUND TEMPERATURES,0",
        "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0",
        "COMMENTS 1,synthetic: written by scenes/museum-hall/make_daylight.py; nobody has measured it",
        "COMMENTS 2,",
        "DATA PERIODS,1,1,Data,Sunday,1/1,12/31",
    ]
    for month in range(1, 13):
        for day in range(1, DAYS[month - 1] + 1):
            for hour in range(1, 25):
                altitude = sun_altitude(day_of_year(month, day), hour - 0.5)
                direct, diffuse = clear_sky(altitude)
                whole = diffuse + direct * math.sin(math.radians(max(altitude, 0)))
                lines.append(
                    f"2023,{month},{day},{hour},0,_,15.0,9.0,70,95000,9999,9999,9999,{whole:.0f},{direct:.0f},"
                    f"{diffuse:.0f},999999,999999,999999,9999,999,999,99,99,9999,99999,9,999999999,999,0.999,999,99,"
                    "999,999,99"
                )
    write(path, "\n".join(lines) + "\n")


def write(path: pathlib.Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--type", type=int, default=12, help="the CIE's type of the sky, 1 to 16")
    parser.add_argument("--date", default="6-21", help="month and day")
    parser.add_argument("--hour", type=float, default=11, help="by the clock, winter time")
    parser.add_argument("--weather", type=pathlib.Path, metavar="FILE")
    asked = parser.parse_args()
    month, day = (int(number) for number in asked.date.split("-"))
    if asked.weather:
        write_weather(asked.weather)
    else:
        write(HERE / "daylight.textproto", hall(sky(asked.type, month, day, asked.hour)))


if __name__ == "__main__":
    main()
