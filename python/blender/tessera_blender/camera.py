"""Blender's camera as one of Tessera: perspective, orthographic and Cycles' panoramas, depth of field, stereo."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from tessera import Scene

from .motion import array_of


class CameraExport:
    """One camera. ValueError, with its name, for what has no counterpart; `warn` gets what is left out."""

    def __init__(self, scene: Scene, depsgraph: Any, camera: Any, place: Any, warn: Callable[[str], None]) -> None:
        """`place`: world from camera, z into the scene."""
        self._scene, self._depsgraph, self._camera, self._place, self._warn = scene, depsgraph, camera, place, warn
        self._render = depsgraph.scene_eval.render
        film = scene.message.film
        self._width, self._height = film.width, film.height
        self._clip = (camera.data.clip_start, camera.data.clip_end)

    def write(self) -> None:
        data = self._camera.data
        if data.type == "PANO":
            self._panorama()
        else:
            self._flat(data.type == "ORTHO")
        if self._is_stereo():
            self._stereo()

    def _refuse(self, what: str) -> ValueError:
        return ValueError(f"camera {self._camera.name}: {what}")

    def _flat(self, is_orthographic: bool) -> None:
        projection = array_of(
            self._camera.calc_matrix_camera(
                self._depsgraph,
                x=self._width,
                y=self._height,
                scale_x=self._render.pixel_aspect_x,
                scale_y=self._render.pixel_aspect_y,
            )
        )
        # Where the picture ends, on the plane at distance 1, or anywhere.
        column, sign = (3, -1) if is_orthographic else (2, 1)
        window = []
        for row in (0, 1):
            window += [(edge + sign * projection[row, column]) / projection[row, row] for edge in (-1, 1)]
        lens = self._lens(1.0 if is_orthographic else 1e-3 * self._camera.data.lens)
        if is_orthographic:
            self._scene.orthographic_camera(
                self._place, (window[0], window[1], window[2], window[3]), self._clip, **lens
            )
            return
        self._scene.camera(self._place, 90.0, clip=self._clip, **lens)
        self._scene.message.camera.screen_window[:] = window

    def _lens(self, focal_length: float) -> dict[str, Any]:
        """Depth of field, as the arguments of a camera; f-numbers are of a focal length in metres."""
        dof = self._camera.data.dof
        if not dof.use_dof:
            return {}
        distance = dof.focus_distance
        if dof.focus_object is not None:
            target = np.array(dof.focus_object.matrix_world.translation)
            # Cycles has things behind the camera at a distance, too.
            distance = abs(float(np.dot(target - self._place[:3, 3], self._place[:3, 2])))
        lens: dict[str, Any] = {
            "lens_radius": focal_length / (2 * max(dof.aperture_fstop, 1e-5)),
            "focal_distance": max(distance, 0.0),
            "aperture_ratio": dof.aperture_ratio,
        }
        if dof.aperture_blades >= 3:  # Blender's are round with fewer
            # Blender turns the middle of an edge.
            turn = float(np.degrees(dof.aperture_rotation)) + 180 / dof.aperture_blades
            lens |= {"blades": dof.aperture_blades, "blade_degrees": turn}
        return lens

    # ---- panoramas: the whole picture is that of Cycles' film, whatever its proportions

    def _panorama(self) -> None:
        """Cycles has the kind of a panorama among its own settings."""
        lens = self._camera.data.cycles
        kinds = {
            "EQUIRECTANGULAR": self._equirectangular,
            "EQUIANGULAR_CUBEMAP_FACE": self._cube_face,
            "MIRRORBALL": self._mirror_ball,
            "FISHEYE_EQUIDISTANT": self._equidistant,
            "FISHEYE_EQUISOLID": self._equisolid,
            "FISHEYE_LENS_POLYNOMIAL": self._polynomial,
        }
        if lens.panorama_type not in kinds:
            raise self._refuse(f"panoramas of kind {lens.panorama_type} are not translated")
        if self._camera.data.dof.use_dof and (lens.panorama_type != "EQUIRECTANGULAR" or self._is_around()):
            what = "stereo of all directions" if self._is_around() else f"a panorama of kind {lens.panorama_type}"
            self._warn(f"camera {self._camera.name}: depth of field of {what} is left out")
        kinds[lens.panorama_type](lens)

    def _equirectangular(self, lens: Any) -> None:
        def degrees(low: float, high: float) -> tuple[float, float]:
            return float(np.degrees(low)), float(np.degrees(high))

        longitudes = degrees(lens.longitude_min, lens.longitude_max)
        # Numbers of 32 bits go a little beyond the poles.
        low, high = degrees(lens.latitude_min, lens.latitude_max)
        if longitudes[0] >= longitudes[1] or low >= high:
            raise self._refuse("a panorama whose longitudes or latitudes descend is not translated")
        longitudes = (longitudes[0], min(longitudes[1], longitudes[0] + 360.0))
        dof = {} if self._is_around() else self._lens(1e-3 * self._camera.data.lens)
        self._scene.panorama_camera(self._place, longitudes, (max(low, -90.0), min(high, 90.0)), self._clip, **dof)

    def _cube_face(self, lens: Any) -> None:
        if self._width != self._height:
            size = f"{self._width}x{self._height}"
            raise self._refuse(f"the face of a cube that is stretched to {size} is not translated")
        self._scene.cube_map_camera(self._place, "front", equiangular=True, clip=self._clip)

    def _fisheye(self, mapping: str, fov: float, circle: float, window: list[float]) -> None:
        self._scene.fisheye_camera(self._place, fov, mapping, min(circle, 360.0), self._clip)
        self._scene.message.camera.screen_window[:] = window

    def _mirror_ball(self, lens: Any) -> None:
        # The normal at the sine of an angle from the middle reflects twice that angle.
        self._fisheye("equisolid", 360.0, 360.0, [-1, 1, -1, 1])

    def _equidistant(self, lens: Any) -> None:
        fov = float(np.degrees(lens.fisheye_fov))
        if fov > 360.0001:
            raise self._refuse(f"a fisheye of {fov:g} degrees, which shows directions twice, is not translated")
        self._fisheye("equidistant", min(fov, 360.0), fov, [-1, 1, -1, 1])

    def _sensor(self) -> tuple[float, float]:
        """Width and height of what the picture takes of the sensor, in millimetres."""
        data = self._camera.data
        x, y = self._width * self._render.pixel_aspect_x, self._height * self._render.pixel_aspect_y
        size = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
        is_width = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and x > y)
        return (size, size * y / x) if is_width else (size * x / y, size)

    def _equisolid(self, lens: Any) -> None:
        # All directions are within a radius of twice the focal length.
        x, y = (side / (4 * lens.fisheye_lens) for side in self._sensor())
        self._fisheye("equisolid", 360.0, float(np.degrees(lens.fisheye_fov)), [-x, x, -y, y])

    def _polynomial(self, lens: Any) -> None:
        """Cycles' angles are minus a polynomial of the distance in millimetres. Places of our film are the
        distance times the polynomial's slope in the middle."""
        k = [getattr(lens, f"fisheye_polynomial_k{i}") for i in range(5)]
        slope = -k[1]
        if slope <= 0:
            raise self._refuse("a lens polynomial whose k1 is not below 0 is not translated")
        if abs(k[0]) > 1e-3:
            raise self._refuse(f"a lens polynomial with a k0 of {k[0]:g} has a hole in its middle: not translated")
        x, y = (slope * side / math.pi for side in self._sensor())
        # 180 degrees span pi.
        self._fisheye("equidistant", 180.0, float(np.degrees(lens.fisheye_fov)), [-x, x, -y, y])
        polynomial = self._scene.message.camera.distortion.polynomial
        polynomial.angle[:] = [-k[i] / slope**i for i in range(1, 5)]

    # ---- stereo

    def _is_around(self) -> bool:
        """Whether eyes go around the camera on circles, which have no lens."""
        render = self._render
        return bool(
            self._camera.data.type == "PANO" and render.use_multiview and render.views_format == "STEREO_3D"
        )

    def _is_stereo(self) -> bool:
        if not self._render.use_multiview:
            return False
        if self._render.views_format != "STEREO_3D":
            self._warn("cameras of a multi-view picture are left out, but for the scene's own")
            return False
        return True

    def _stereo(self) -> None:
        data, stereo = self._camera.data, self._camera.data.stereo
        axes = {"OFFAXIS": "off_axis", "PARALLEL": "parallel", "TOE": "toe_in"}[stereo.convergence_mode]
        distance = 0.0 if axes == "parallel" else stereo.convergence_distance
        merge = (0.0, 0.0)
        around = data.type == "PANO"
        if around and (not stereo.use_spherical_stereo or data.cycles.panorama_type != "EQUIRECTANGULAR"):
            raise self._refuse("stereo of a panorama is translated where it is spherical, and equirectangular")
        if around and stereo.use_pole_merge:
            merge = (
                float(np.degrees(stereo.pole_merge_angle_from)),
                min(float(np.degrees(stereo.pole_merge_angle_to)), 90.0),
            )
        self._scene.stereo_pair(stereo.interocular_distance, distance, axes, merge)
        if stereo.pivot != "CENTER" and not around:
            # One of the eyes stands where the camera does.
            shift = stereo.interocular_distance / 2 * (1 if stereo.pivot == "LEFT" else -1)
            for camera in (self._scene.message.camera, self._scene.message.views[0]):
                camera.viewpoint.x += shift
