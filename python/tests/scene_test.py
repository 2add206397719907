"""Scenes in code, without a farm."""

from __future__ import annotations

import struct
import subprocess
import tempfile
import unittest
import warnings
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import tessera
from farm_under_test import PROGRAM, small_scene
from tessera import _job
from tessera._mesh import encode_mesh, encode_pfm
from tessera.v1 import settings_pb2


class SceneTest(unittest.TestCase):
    def test_cameras_look_where_they_are_told(self) -> None:
        matrix = tessera.look_at((1, 2, 3), (1, 2, -3))
        np.testing.assert_allclose(matrix @ [0, 0, 1, 0], [0, 0, -1, 0], atol=1e-15)
        np.testing.assert_allclose(matrix @ [1, 0, 0, 0], [1, 0, 0, 0], atol=1e-15)
        np.testing.assert_allclose(matrix @ [0, 1, 0, 0], [0, 1, 0, 0], atol=1e-15)
        np.testing.assert_allclose(matrix[:3, 3], [1, 2, 3])
        with self.assertRaisesRegex(ValueError, "look_at"):
            tessera.look_at((0, 0, 0), (0, 1, 0))

    def test_daylight_is_of_a_place_and_a_moment(self) -> None:
        scene = tessera.Scene()
        summer = timezone(timedelta(hours=2))
        scene.daylight(12, when=datetime(2024, 6, 21, 14, 30, tzinfo=summer), place=(48.1, 11.6), y_up=True)
        sky = scene.message.lights[0].sky
        self.assertEqual((sky.cie_type, sky.when.hour, sky.when.utc_offset_hours), (12, 14.5, 2))
        self.assertEqual((sky.when.latitude_degrees, sky.when.longitude_degrees), (48.1, 11.6))
        self.assertFalse(sky.HasField("diffuse_horizontal_illuminance"))
        scene.daylight(perez=(600, 120), toward_sun=(0, 1, 1), sun_degrees=0, name="day")
        sky = scene.message.lights[1].sky
        self.assertEqual((sky.perez.direct_normal_irradiance, sky.perez.diffuse_horizontal_irradiance), (600, 120))
        self.assertTrue(sky.HasField("sun_degrees"))
        with self.assertRaisesRegex(ValueError, "needs a time zone"):
            scene.daylight(12, when=datetime(2024, 6, 21), place=(48.1, 11.6))
        with self.assertRaisesRegex(ValueError, "either cie_type or perez"):
            scene.daylight()

    def test_lenses_have_blades(self) -> None:
        scene = tessera.Scene()
        scene.camera(np.eye(4), 40, 0.1, 3, blades=5, blade_degrees=20, aperture_ratio=2)
        aperture = scene.message.camera.perspective.aperture
        self.assertEqual((aperture.blades, aperture.blade_degrees, aperture.ratio), (5, 20, 2))
        scene.camera(np.eye(4), 40, 0.1, 3)
        self.assertFalse(scene.message.camera.perspective.HasField("aperture"))

    def test_orthographic_lenses_have_blades_too(self) -> None:
        scene = tessera.Scene()
        scene.orthographic_camera(np.eye(4), (-1, 1, -2, 2), lens_radius=0.1, focal_distance=3, blades=5)
        lens = scene.message.camera.orthographic
        self.assertEqual((lens.focal_distance, lens.aperture.blades), (3, 5))

    def test_panoramas_have_lenses_too(self) -> None:
        scene = tessera.Scene()
        scene.panorama_camera(np.eye(4), (-90, 90), lens_radius=0.1, focal_distance=3, blades=5, aperture_ratio=2)
        lens = scene.message.camera.panorama
        self.assertEqual((lens.focal_distance, lens.aperture.blades, lens.aperture.ratio), (3, 5, 2))
        scene.panorama_camera(np.eye(4))
        self.assertEqual(scene.message.camera.panorama.lens_radius, 0)
        self.assertFalse(scene.message.camera.panorama.HasField("aperture"))

    def test_cameras_of_opencv_have_its_matrix_and_coefficients(self) -> None:
        matrix = [[500, 0, 300], [0, 520, 250], [0, 0, 1]]
        scene = tessera.Scene()
        scene.opencv_camera(np.eye(4), matrix, (640, 480), [-0.2, 0.1, 0.01, -0.02, 0.3])
        camera = scene.message.camera
        self.assertEqual((scene.message.film.width, scene.message.film.height), (640, 480))
        self.assertEqual((camera.distortion.opencv.p2, camera.distortion.opencv.k3), (-0.02, 0.3))
        # The middle of pixel (300, 250) is on the axis: 90 degrees span from -1 to 1.
        left, right, low, high = camera.screen_window
        self.assertEqual(camera.perspective.fov_degrees, 90)
        self.assertAlmostEqual(left + 300.5 / 640 * (right - left), 0, 6)
        self.assertAlmostEqual(high - 250.5 / 480 * (high - low), 0, 6)
        self.assertAlmostEqual(640 / (right - left), 500, 3)
        self.assertAlmostEqual(480 / (high - low), 520, 3)
        scene.opencv_camera(np.eye(4), matrix, (640, 480), [0.1], fisheye=True)
        self.assertEqual(camera.distortion.opencv_fisheye.k1, 0.1)
        self.assertAlmostEqual(camera.fisheye.fov_degrees, np.degrees(2), 4)
        scene.opencv_camera(np.eye(4), matrix, (640, 480))
        self.assertFalse(camera.HasField("distortion"))
        with self.assertRaisesRegex(ValueError, "4 coefficients at most"):
            scene.opencv_camera(np.eye(4), matrix, (640, 480), [0.1] * 5, fisheye=True)

    def test_stereo_pairs_are_two_views_about_the_camera(self) -> None:
        scene = tessera.Scene()
        scene.panorama_camera(tessera.translate(1, 2, 3), (-90, 90))
        scene.stereo_pair(0.06, 2, pole_merge=(60, 75))
        left, right = scene.message.camera, scene.message.views[0]
        self.assertEqual((left.view_name, right.view_name), ("left", "right"))
        self.assertEqual((left.viewpoint.x, right.viewpoint.x), (-0.03, 0.03))
        self.assertEqual(left.panorama, right.panorama)
        self.assertEqual(right.viewpoint.pole_merge_to_degrees, 75)
        self.assertEqual(scene.message.render_origin.z, 3)
        with self.assertRaisesRegex(ValueError, "there is no kind of axes 'crossed'"):
            scene.stereo_pair(0.06, 2, axes="crossed")

    def test_pinholes_have_a_hole_and_a_film(self) -> None:
        scene = tessera.Scene()
        scene.pinhole_camera(np.eye(4), 0.3, 60, "4x5", scene_distance=2, diffraction=False)
        pinhole = scene.message.camera.pinhole
        self.assertEqual((pinhole.hole_mm, pinhole.film_distance_mm, pinhole.film_gauge), (0.3, 60, "4x5"))
        self.assertEqual((pinhole.scene_distance, pinhole.diffraction), (2, pinhole.STRAIGHT))

    def test_lights_have_amounts_and_files(self) -> None:
        scene = tessera.Scene()
        scene.units(metres=0.01)
        scene.point_light((0, 0, 1), amount=(800, "lm"))
        scene.spot_light((0, 0, 1), (0, 0, 0), (1, 0.5, 0.2), amount=(300, "cd"))
        scene.distant_light((0, 0, -1), amount=(1000, "lx"))
        scene.environment(1, amount=(5000, "cd/m2"))
        scene.rectangle([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], emission=1, amount=(36, "W"))
        with tempfile.TemporaryDirectory() as folder:
            lamp = Path(folder) / "lamp.ies"
            lamp.write_text("IES:LM-63-2019\nTILT=NONE\n")
            scene.photometric_light(lamp, tessera.translate(0, 0, 3), scale=0.5)
        lights = scene.message.lights
        self.assertEqual([light.amount.unit for light in lights], ["lm", "cd", "lx", "cd/m2", ""])
        self.assertEqual(scene.message.shapes[0].area_light.amount.value, 36)
        self.assertEqual(scene.message.units.metres, 0.01)
        file = lights[4].goniometric.photometric_file
        self.assertEqual((file.path, lights[4].scale), ("lamp.ies", 0.5))
        self.assertIn(file.digest, scene.blobs)
        with self.assertRaisesRegex(ValueError, "an amount of light is 0 or more, not -1 lm"):
            scene.point_light((0, 0, 1), amount=(-1, "lm"))
        with self.assertRaisesRegex(ValueError, "metres: expected a number above 0"):
            scene.units(metres=0)

    def test_meshes_that_make_no_sense_are_refused(self) -> None:
        square = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
        for arrays, what in (
            ((square, [(0, 1, 3)]), "an index is not below the 3 vertices"),
            ((square, [(0, 1, -1)]), "an index"),
            ((square, [(0, 1, 1.5)]), "expected integers"),
            (([(0, 0)], [(0, 0, 0)]), r"expected an array of shape \(n, 3\)"),
            (([(0, 0, np.nan)], [(0, 0, 0)]), "not all values are finite"),
            ((square, [(0, 1, 2)], [(0, 0, 1)]), "expected one a vertex"),
        ):
            with self.assertRaisesRegex(ValueError, what):
                encode_mesh(*arrays)  # type: ignore[arg-type]
        blob = encode_mesh(square, np.array([(0, 1, 2)]))
        self.assertEqual(struct.unpack_from("<8sIIQQ", blob), (b"TSRMESH1", 0, 0, 3, 1))
        self.assertEqual(len(blob), 32 + 48 + 12)
        with self.assertRaisesRegex(ValueError, "expected an array"):
            encode_pfm(np.zeros((2, 2, 4)))

    def test_names_are_unique_and_words_are_known(self) -> None:
        scene = tessera.Scene()
        scene.diffuse("paint", 0.5)
        with self.assertRaisesRegex(ValueError, "already"):
            scene.conductor("paint", 0.5)
        with self.assertRaisesRegex(ValueError, "there is no filter 'square'"):
            scene.film(8, 8, filter="square")
        with self.assertRaisesRegex(ValueError, "4 x 4"):
            scene.camera(np.eye(3))

    def test_numbers_that_are_none_are_refused_at_once(self) -> None:
        nan = float("nan")
        scene = tessera.Scene()
        square = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
        for call, place in (
            (lambda: scene.sphere(nan), "Shape.sphere.radius"),
            (lambda: scene.box((0, 0, nan), (1, 1, 1)), "Shape.box.low"),
            (lambda: scene.rectangle(square, emission=nan), "Shape.area_light.radiance.constant"),
            (lambda: scene.diffuse("paint", (0.5, nan, 0.5)), "Material.diffuse.reflectance.constant.rgb.g"),
            (lambda: scene.principled("car", ior=float("inf")), "Material.principled.eta"),
            (lambda: scene.principled("car", roughness=1e39), "Material.principled.roughness.constant"),
            (lambda: scene.checkerboard("tiles", 0.1, 0.2, (nan, 1)), "mapping.scale_u"),
            (lambda: scene.point_light((0, nan, 0), 1), "Light.point.position.y"),
            (lambda: scene.spot_light((0, 1, 0), (0, 0, 0), 1, cone_angle=nan), "cone_angle_degrees"),
            (lambda: scene.point_light((0, 1, 0), 1, radius=nan), "Light.point.radius"),
            (lambda: scene.environment(1, scale=nan), "Light.infinite.scale"),
            (lambda: scene.environment(np.full((2, 4, 3), np.nan)), "not all values are finite"),
            (lambda: scene.camera(np.eye(4), fov=nan), "Camera.perspective.fov_degrees"),
            (lambda: scene.camera(np.eye(4), clip=(nan, 1)), "Camera.near_clip"),
            (lambda: scene.film(8, 8, exposure=nan), "Film.exposure"),
        ):
            with self.subTest(place), self.assertRaisesRegex(ValueError, place):
                call()
        self.assertEqual(scene.message, tessera.Scene().message, "and nothing of them is left")
        scene = small_scene()
        scene.settings.noise = nan
        with self.assertRaisesRegex(ValueError, "Scene.settings.noise"):
            _job.make_spec(scene, "tester")

    def test_what_stops_pixels_from_sharing_is_told(self) -> None:
        """Layers, the AOV variance; not where the user said so, nor where paths have nothing to share."""

        def told(aovs: tuple[str, ...] = (), layers: bool = False, **settings: object) -> list[str]:
            scene = small_scene()
            for name, value in settings.items():
                setattr(scene.settings, name, value)
            if layers:
                scene.settings.layers.add(name="lit", expression="LDE")
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                _job.make_spec(scene, "tester", aovs=aovs)
            return [str(warning.message) for warning in caught]

        off = settings_pb2.PATH_SHARING_OFF
        self.assertEqual(told(), [])
        self.assertEqual(told(aovs=("depth",)), [])
        self.assertRegex("".join(told(aovs=("variance",))), "^pixels do not share .* because of the AOV variance")
        self.assertRegex("".join(told(layers=True)), "^pixels do not share .* because of layers")
        for quiet in ({"path_sharing": off}, {"integrator": "direct"}, {"max_depth": 1}):
            self.assertEqual(told(aovs=("variance",), **quiet), [], quiet)

    def test_a_lamp_of_known_power_lights_a_floor(self) -> None:
        """Irradiance of a distant light, and of a lamp: the radiance of white paint is that over pi."""
        for light in ("distant", "point"):
            scene = tessera.Scene("floor")
            white = scene.diffuse("white", 1.0)
            corners = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
            scene.rectangle(corners, white)
            if light == "distant":
                scene.distant_light((0, 0, -1), np.pi)
            else:
                scene.point_light((0, 0, 2), 4 * np.pi)  # at a distance of 2
            scene.camera(tessera.look_at((0, 0, 1), (0, 0, 0), (0, 1, 0)), 1)
            scene.film(4, 4)
            scene.settings.max_depth, scene.settings.spp = 1, 1
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "scene.textproto"
                scene.save(file)
                image = str(Path(folder) / "image.exr")
                subprocess.run([PROGRAM, "render", str(file), "-o", image, "--quiet"], check=True)
                from farm_under_test import read_exr

                # A degree across, so that all of the picture has the same irradiance, to 4 sin^2 of that.
                np.testing.assert_allclose(read_exr(Path(image))["R"], 1, rtol=3e-4)

    def test_files_name_all_blobs(self) -> None:
        scene = small_scene()
        with tempfile.TemporaryDirectory() as folder:
            scene.save(Path(folder) / "a.textproto")
            written = sorted(path.suffix for path in (Path(folder) / "a.blobs").iterdir())
            self.assertEqual(written, [".mesh", ".pfm"])
            self.assertNotIn("digest", (Path(folder) / "a.textproto").read_text())

    def test_png_and_srgb(self) -> None:
        self.assertEqual(list(tessera.to_srgb(np.array([0.0, 0.5, 1.0, 7.0]))), [0, 188, 255, 255])
        with tempfile.TemporaryDirectory() as folder:
            tessera.write_png(Path(folder) / "a.png", np.zeros((2, 3, 3), np.uint8))
            self.assertEqual((Path(folder) / "a.png").read_bytes()[:4], b"\x89PNG")


if __name__ == "__main__":
    unittest.main()
