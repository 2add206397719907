"""Measured light, in this process and on a farm."""

from __future__ import annotations

import math
import tempfile
import unittest
import unittest.mock
import warnings
from pathlib import Path

import numpy as np
import tessera
from farm_under_test import PROGRAM, FarmUnderTest
from tessera.v1 import meter_pb2

_LAMP = 3.0  # W/sr, at a height of 2


def _lamplit() -> tessera.Scene:
    """A black table of 2 x 2, a little below z = 0, and a lamp above its middle."""
    scene = tessera.Scene("lamplit")
    black = scene.diffuse("black", 0.0)
    corners = [(-1, -1, -0.001), (1, -1, -0.001), (1, 1, -0.001), (-1, 1, -0.001)]
    scene.mesh(corners, np.array([(0, 1, 2), (0, 2, 3)]), black, name="table")
    scene.point_light((0, 0, 2), _LAMP)
    scene.camera(tessera.look_at((0, -5, 1), (0, 0, 0), (0, 0, 1)), 40)
    scene.film(8, 8)
    return scene


_METERS = """
    unit: "m"
    meters { name: "below" unit: "W/m2" irradiance { receivers { point {} } } }
    meters { name: "aside" unit: "W/m2" irradiance { receivers { point { position { x: 1 } } } } }
    meters { name: "contrast" ratio { kind: WEBER of: "aside" over: "below" } }
    meters { name: "grid" unit: "W/m2" irradiance { receivers { plane {
      corner { x: -1 y: -1 } edge_u { x: 2 } edge_v { y: 2 } columns: 3 rows: 2 } } } }
    meters { name: "table" unit: "W/m2" irradiance { receivers { surface { shape: "table" by_triangle: true } } } }
"""


class MeasureTest(unittest.TestCase):
    def measure(self, meters: object, **more: object) -> tessera.Measured:
        return tessera.measure(_lamplit(), meters, program=PROGRAM, **more)  # type: ignore[arg-type]

    def test_figures_have_units_and_errors(self) -> None:
        measured = self.measure(tessera.meters(_METERS), samples=1024, seed=7)
        self.assertTrue(measured.complete)
        self.assertEqual([meter.name for meter in measured.meters], ["below", "aside", "contrast", "grid", "table"])
        below = measured["below"].figure
        self.assertEqual((below.unit, below.quantity, below.integrator), ("W/m2", "irradiance", "path"))
        self.assertEqual((below.position, below.normal), ((0, 0, 0), (0, 0, 1)))
        # A point light has no variance: inverse squares, and cosines.
        self.assertAlmostEqual(below.value, _LAMP / 4, delta=1e-5)
        self.assertLessEqual(below.interval[0], below.value)
        self.assertGreaterEqual(below.samples, 1024)
        aside = _LAMP * 2 / math.sqrt(5) ** 3
        self.assertAlmostEqual(measured["aside"].value, aside, delta=1e-5)
        self.assertAlmostEqual(measured["contrast"].value, aside / (_LAMP / 4) - 1, delta=1e-4)
        with self.assertRaisesRegex(KeyError, "no meter 'sofa'"):
            measured["sofa"]
        with self.assertRaisesRegex(ValueError, "has 6 figures"):
            _ = measured["grid"].value

    def test_planes_and_surfaces_are_arrays(self) -> None:
        measured = self.measure(tessera.meters(_METERS), error=0.02)
        (grid,) = measured["grid"].grids
        self.assertEqual(grid.values.shape, (2, 3))
        np.testing.assert_allclose(grid.positions[1, 2, :2], [2 / 3, 0.5])
        self.assertTrue((grid.low <= grid.values).all() and (grid.values <= grid.high).all())
        self.assertLess(grid.values[0, 0], grid.values[0, 1])
        np.testing.assert_allclose(grid.mean, grid.values.mean())
        (surface,) = measured["table"].surfaces
        self.assertEqual((surface.shape, surface.vertices.shape, surface.triangles.shape), ("table", (4, 3), (2, 3)))
        # Both halves of the table see the lamp alike, and together they are the table.
        np.testing.assert_allclose(surface.values, grid.mean, rtol=0.05)
        self.assertEqual([figure.cell for figure in measured["table"].figures], ["0", "1"])
        self.assertEqual(measured.wanted_error, 0.02)
        self.assertLessEqual(measured.worst_error, 0.02)

    def test_faults_are_those_of_the_program(self) -> None:
        with self.assertRaisesRegex(tessera.TesseraError, r"meter 1 \(a\): there is no shape 'sofa'"):
            self.measure(
                tessera.meters('meters { name: "a" irradiance { receivers { surface { shape: "sofa" } } } }')
            )
        with self.assertRaisesRegex(ValueError, "^1:"):
            tessera.meters("meters { iradiance {} }")
        with self.assertRaisesRegex(tessera.TesseraError, "not on the PATH|No such file"):
            with unittest.mock.patch.dict("os.environ", {"PATH": ""}):
                tessera.measure(_lamplit(), tessera.meters(_METERS))

    def test_warnings_and_time_are_told(self) -> None:
        dark = meter_pb2.MeterList()
        dark.meters.add(name="under it").irradiance.receivers.add().point.position.z = -1
        with self.assertWarnsRegex(UserWarning, "under it: no light at all reaches it"):
            measured = self.measure(dark, samples=64)
        self.assertEqual(len(measured["under it"].warnings), 1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            late = self.measure(tessera.meters(_METERS), error=1e-9, seconds=0)
        self.assertFalse(late.complete)

    def test_a_farm_finds_the_same_figures(self) -> None:
        with tempfile.TemporaryDirectory() as folder, FarmUnderTest() as under_test:
            file = Path(folder) / "meters.textproto"
            file.write_text(_METERS)
            here = self.measure(file, samples=1024)
            with under_test.connect() as farm:
                there = tessera.measure(_lamplit(), file, samples=1024, server=farm)
        self.assertEqual([f.value for f in here.figures], [f.value for f in there.figures])


if __name__ == "__main__":
    unittest.main()
