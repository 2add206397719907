"""Cameras: perspectives, panoramas, fisheyes, lens systems; distortion and stereo."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tessera._scene_message import SceneMessage
from tessera._values import checked, choice, matrix_message
from tessera.v1 import camera_pb2, rig_pb2, value_pb2

_FILTERS = {kind.lower(): number for kind, number in camera_pb2.PixelFilter.Kind.items()}
_FISHEYES = {kind.lower(): number for kind, number in camera_pb2.FisheyeCamera.Mapping.items()}
_SPHERES = {kind.lower(): number for kind, number in camera_pb2.SphericalCamera.Mapping.items()}
_LAYOUTS = {kind.lower(): number for kind, number in camera_pb2.CubeMapCamera.Layout.items()}
_AXES = {kind.lower(): number for kind, number in rig_pb2.Viewpoint.Axes.items()}
# In the order in which OpenCV's functions have them.
_OPENCV = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tau_x_radians", "tau_y_radians"]
_OPENCV_FISHEYE = ["k1", "k2", "k3", "k4"]


def _set_lens(
    lens: Any, radius: float, focal_distance: float, blades: int, blade_degrees: float, ratio: float
) -> None:
    """The lens of a perspective or an orthographic camera, or of a panorama."""
    lens.ClearField("aperture")
    if blades:
        lens.aperture.blades = blades
        lens.aperture.blade_degrees = blade_degrees
    if ratio != 1.0:
        lens.aperture.ratio = ratio
    lens.lens_radius = radius
    lens.focal_distance = focal_distance


class Cameras(SceneMessage):
    """Each camera takes the place of the one before."""

    def camera(
        self,
        world_from_camera: npt.ArrayLike,
        fov: float = 50.0,
        lens_radius: float = 0.0,
        focal_distance: float = 0.0,
        clip: tuple[float, float] = (0.0, 0.0),
        blades: int = 0,
        blade_degrees: float = 0.0,
        aperture_ratio: float = 1.0,
    ) -> None:
        """A perspective camera (`look_at`); `fov` is across the film's shorter side. Camera space has x to
        the right, y up, and z into the scene. The lens is open in a circle of `lens_radius`, or in a polygon of
        `blades` corners on that circle, the first in the direction of `blade_degrees` from x towards y;
        `aperture_ratio` is height over width, by which x is then divided."""
        with self._placed(world_from_camera, clip) as camera:
            _set_lens(camera.perspective, lens_radius, focal_distance, blades, blade_degrees, aperture_ratio)
            camera.perspective.fov_degrees = fov

    def orthographic_camera(
        self,
        world_from_camera: npt.ArrayLike,
        screen_window: tuple[float, float, float, float],
        clip: tuple[float, float] = (0.0, 0.0),
        lens_radius: float = 0.0,
        focal_distance: float = 0.0,
        blades: int = 0,
        blade_degrees: float = 0.0,
        aperture_ratio: float = 1.0,
    ) -> None:
        """Parallel rays through x_min, x_max, y_min, y_max of camera space, or a lens as that of `camera`."""
        with self._placed(world_from_camera, clip) as camera:
            camera.orthographic.SetInParent()
            _set_lens(camera.orthographic, lens_radius, focal_distance, blades, blade_degrees, aperture_ratio)
            camera.screen_window[:] = screen_window

    def fisheye_camera(
        self,
        world_from_camera: npt.ArrayLike,
        fov: float = 180.0,
        mapping: str = "equidistant",
        circle: float = 0.0,
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """`mapping`: equidistant, equisolid, stereographic or orthographic; `fov` is across the film's shorter
        side, `circle` across the circle beyond which the film is black (0: there is none); degrees."""
        with self._placed(world_from_camera, clip) as camera:
            camera.fisheye.mapping = choice(_FISHEYES, mapping, "mapping of a fisheye")
            camera.fisheye.fov_degrees = fov
            camera.fisheye.circle_degrees = circle

    def lens_camera(
        self,
        world_from_camera: npt.ArrayLike,
        lens: camera_pb2.LensPrescription,
        focus: float = 0.0,
        f_number: float = 0.0,
        film_diagonal: float = 0.0,
        blades: int = 0,
        units_per_mm: float = 0.001,
        clip: tuple[float, float] = (0.0, 0.0),
        film_gauge: str = "",
    ) -> None:
        """A lens system, whose `lens` `google.protobuf.text_format.Parse` reads from a file. `focus` is the
        distance from the film of what is sharp (0: infinity); the lens is as open as `f_number` says (0: fully);
        `film_diagonal` in millimetres (0: 43.27), or `film_gauge` by name: "super35"; a stop of `blades` is a
        polygon (0: round)."""
        with self._placed(world_from_camera, clip) as camera:
            camera.lens.Clear()
            camera.lens.lens.CopyFrom(lens)
            camera.lens.focus_distance = focus
            camera.lens.f_number = f_number
            camera.lens.film_diagonal_mm = film_diagonal
            camera.lens.film_gauge = film_gauge
            if blades:
                camera.lens.blades = blades
            camera.lens.units_per_mm = units_per_mm

    def pinhole_camera(
        self,
        world_from_camera: npt.ArrayLike,
        hole: float,
        film_distance: float,
        film_gauge: str = "",
        film_diagonal: float = 0.0,
        scene_distance: float = 0.0,
        diffraction: bool = True,
        units_per_mm: float = 0.001,
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """A box with a round hole, of a diameter and at a distance from the film in millimetres. The film is of a
        gauge, "4x5", or of a diagonal in millimetres (0: 43.27). `scene_distance`: of what diffraction is exact
        for (0: infinity); without `diffraction`, light goes straight."""
        with self._placed(world_from_camera, clip) as camera:
            camera.pinhole.Clear()
            camera.pinhole.hole_mm = hole
            camera.pinhole.film_distance_mm = film_distance
            camera.pinhole.film_gauge = film_gauge
            camera.pinhole.film_diagonal_mm = film_diagonal
            camera.pinhole.scene_distance = scene_distance
            if not diffraction:
                camera.pinhole.diffraction = camera_pb2.PinholeCamera.STRAIGHT
            camera.pinhole.units_per_mm = units_per_mm

    def cylindrical_camera(
        self,
        world_from_camera: npt.ArrayLike,
        fov: float = 360.0,
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """A panorama in which upright lines are straight; `fov` is across the film's width, in degrees."""
        with self._placed(world_from_camera, clip) as camera:
            camera.cylindrical.fov_degrees = fov

    def spherical_camera(
        self,
        world_from_camera: npt.ArrayLike,
        mapping: str = "equirectangular",
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """All directions, +y of camera space up; `mapping` is one of SphericalCamera.Mapping. The middle of an
        equirectangular picture looks along -x, its right part along -z."""
        with self._placed(world_from_camera, clip) as camera:
            camera.spherical.mapping = choice(_SPHERES, mapping, "mapping of a sphere")

    def panorama_camera(
        self,
        world_from_camera: npt.ArrayLike,
        longitudes: tuple[float, float] = (-180.0, 180.0),
        latitudes: tuple[float, float] = (-90.0, 90.0),
        clip: tuple[float, float] = (0.0, 0.0),
        lens_radius: float = 0.0,
        focal_distance: float = 0.0,
        blades: int = 0,
        blade_degrees: float = 0.0,
        aperture_ratio: float = 1.0,
    ) -> None:
        """Longitudes from the camera's axis to the right across the film, latitudes up; degrees. A lens as that of
        `camera` is at right angles to each ray, and sharp on a sphere."""
        with self._placed(world_from_camera, clip) as camera:
            panorama = camera.panorama
            panorama.longitude_min_degrees, panorama.longitude_max_degrees = longitudes
            panorama.latitude_min_degrees, panorama.latitude_max_degrees = latitudes
            _set_lens(panorama, lens_radius, focal_distance, blades, blade_degrees, aperture_ratio)

    def cube_map_camera(
        self,
        world_from_camera: npt.ArrayLike,
        layout: str = "cross",
        equiangular: bool = False,
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Six faces of a cube in one picture; `layout` is one of CubeMapCamera.Layout."""
        with self._placed(world_from_camera, clip) as camera:
            camera.cube_map.layout = choice(_LAYOUTS, layout, "layout of a cube map")
            camera.cube_map.equiangular = equiangular

    def tilt(self, x: float, y: float, focal_length: float) -> None:
        """Turns the lens of a perspective camera, in degrees: up by `x`, to the right by `y`. The plane of focus
        turns by Scheimpflug's rule, for a lens of this focal length in camera-space units."""
        camera = self._camera()
        lens = camera.perspective.tilt
        lens.x_degrees, lens.y_degrees, lens.focal_length = x, y, focal_length
        self.message.camera.CopyFrom(checked(camera))

    def opencv_camera(
        self,
        world_from_camera: npt.ArrayLike,
        camera_matrix: npt.ArrayLike,
        resolution: tuple[int, int],
        distortion: Sequence[float] = (),
        fisheye: bool = False,
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """A camera that OpenCV has calibrated: its 3 x 3 matrix (fx, fy, cx, cy in pixels of `resolution`, which
        becomes the film's) and its coefficients in OpenCV's order: k1, k2, p1, p2, k3 ... tau_y, or, of cv2.fisheye,
        k1 to k4. OpenCV's cameras have y downwards; `world_from_camera` is Tessera's, y up. Pixels are counted
        from their middles in OpenCV, from the film's corner here."""
        matrix = np.asarray(camera_matrix, np.float64)
        names = _OPENCV_FISHEYE if fisheye else _OPENCV
        if matrix.shape != (3, 3) or len(distortion) > len(names):
            raise ValueError(f"a camera of OpenCV has a 3 x 3 matrix, and {len(names)} coefficients at most")
        (fx, _, cx), (_, fy, cy) = matrix[0], matrix[1]
        width, height = resolution
        self.film(width, height)
        with self._placed(world_from_camera, clip) as camera:
            # A place of the film at 1 is a focal length from the middle: 90 degrees of a perspective span 2, and so do
            # two radians of a fisheye.
            if fisheye:
                camera.fisheye.mapping = camera_pb2.FisheyeCamera.EQUIDISTANT
                camera.fisheye.fov_degrees = float(np.degrees(2.0))
            else:
                camera.perspective.fov_degrees = 90.0
            camera.screen_window[:] = [
                -(cx + 0.5) / fx,
                (width - cx - 0.5) / fx,
                -(height - cy - 0.5) / fy,
                (cy + 0.5) / fy,
            ]
            camera.ClearField("distortion")
            if any(distortion):
                model = camera.distortion.opencv_fisheye if fisheye else camera.distortion.opencv
                for name, value in zip(names, distortion):
                    setattr(model, name, value)

    def distortion_map(self, path: str | Path) -> None:
        """Distorts the camera's film by an ST map: an image of floats, of the film's proportions."""
        path = Path(path)
        self.message.camera.distortion.map.image.CopyFrom(self._add_blob(path.read_bytes(), path.name))

    def stereo_pair(
        self,
        interocular_distance: float,
        convergence_distance: float = 0.0,
        axes: str = "off_axis",
        pole_merge: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Makes the camera so far two: view 0, "left", and view 1, "right". `axes`: off_axis, parallel or toe_in;
        they meet at the convergence distance (0: never). Of panoramas, both eyes go around on circles, which
        become points between the latitudes `pole_merge`."""
        middle = self._camera()
        del self.message.views[:]
        for name, side in (("left", -0.5), ("right", 0.5)):
            camera = self.message.camera if name == "left" else self.message.views.add()
            camera.CopyFrom(middle)
            camera.view_name = name
            view = camera.viewpoint
            view.x, view.axes = side * interocular_distance, choice(_AXES, axes, "kind of axes")
            view.convergence_distance = convergence_distance
            view.pole_merge_from_degrees, view.pole_merge_to_degrees = pole_merge
            checked(camera)
        if not self.message.HasField("render_origin") and middle.world_from_camera.elements:
            place = middle.world_from_camera.elements
            origin = self.message.render_origin
            origin.x, origin.y, origin.z = place[3], place[7], place[11]

    def film(
        self, width: int, height: int, filter: str = "box", exposure: float | None = None
    ) -> None:
        """Size in pixels; `filter`: box, triangle, gaussian, mitchell or lanczos."""
        film = camera_pb2.Film()
        film.CopyFrom(self.message.film)
        film.width, film.height = width, height
        film.filter.kind = choice(_FILTERS, filter, "filter")
        if exposure is not None:
            film.exposure = exposure
        self.message.film.CopyFrom(checked(film))

    def _camera(self) -> camera_pb2.Camera:
        """A copy of the camera so far."""
        camera = camera_pb2.Camera()
        camera.CopyFrom(self.message.camera)
        return camera

    @contextmanager
    def _placed(
        self, world_from_camera: npt.ArrayLike, clip: tuple[float, float]
    ) -> Iterator[camera_pb2.Camera]:
        """The camera so far, to be changed within the block and then put at its place."""
        camera = self._camera()
        yield camera
        camera.world_from_camera.CopyFrom(matrix_message(world_from_camera) or value_pb2.Matrix())
        camera.near_clip, camera.far_clip = clip
        self.message.camera.CopyFrom(checked(camera))
