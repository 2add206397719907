"""Scenes that are built in code.

A `Scene` fills a message of Tessera's scene language (proto/tessera/v1/scene.proto), which is open to whoever
wants more than the functions here: `scene.message`. Spaces: world space is any, right-handed or not; matrices are
4 x 4 and act on column vectors; angles are in degrees; colours are linear Rec.709.
"""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import numpy.typing as npt
from google.protobuf import text_format

from tessera._lights import Lights
from tessera._materials import Materials
from tessera._shapes import Shapes
from tessera._values import Blob, Material, Texture, checked, look_at, matrix_message, translate
from tessera.v1 import blob_ref_pb2, camera_pb2, scene_pb2, settings_pb2, value_pb2

__all__ = ["Blob", "Material", "Scene", "Texture", "look_at", "translate"]

_FILTERS = {kind.lower(): number for kind, number in camera_pb2.PixelFilter.Kind.items()}
_FISHEYES = {kind.lower(): number for kind, number in camera_pb2.FisheyeCamera.Mapping.items()}
_SPHERES = {kind.lower(): number for kind, number in camera_pb2.SphericalCamera.Mapping.items()}
_Kind = TypeVar("_Kind")


def _choice(choices: dict[str, _Kind], name: str, what: str) -> _Kind:
    if name not in choices:
        raise ValueError(f"there is no {what} '{name}'; there are {', '.join(choices)}")
    return choices[name]


class Scene(Materials, Shapes, Lights):
    """A scene, and the bytes of its meshes and pictures. Materials and textures are handles: their names."""

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
        camera = self._camera()
        camera.perspective.ClearField("aperture")
        if blades:
            camera.perspective.aperture.blades = blades
            camera.perspective.aperture.blade_degrees = blade_degrees
        if aperture_ratio != 1.0:
            camera.perspective.aperture.ratio = aperture_ratio
        camera.perspective.fov_degrees = fov
        camera.perspective.lens_radius = lens_radius
        camera.perspective.focal_distance = focal_distance
        self._place_camera(camera, world_from_camera, clip)

    def orthographic_camera(
        self,
        world_from_camera: npt.ArrayLike,
        screen_window: tuple[float, float, float, float],
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Parallel rays through x_min, x_max, y_min, y_max of camera space."""
        camera = self._camera()
        camera.orthographic.SetInParent()
        camera.screen_window[:] = screen_window
        self._place_camera(camera, world_from_camera, clip)

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
        camera = self._camera()
        camera.fisheye.mapping = _choice(_FISHEYES, mapping, "mapping of a fisheye")
        camera.fisheye.fov_degrees = fov
        camera.fisheye.circle_degrees = circle
        self._place_camera(camera, world_from_camera, clip)

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
    ) -> None:
        """A lens system, whose `lens` `google.protobuf.text_format.Parse` reads from a file. `focus` is the
        distance from the film of what is sharp (0: infinity); the lens is as open as `f_number` says (0: fully);
        `film_diagonal` in millimetres (0: 43.27); a stop of `blades` is a polygon (0: round)."""
        camera = self._camera()
        camera.lens.Clear()
        camera.lens.lens.CopyFrom(lens)
        camera.lens.focus_distance = focus
        camera.lens.f_number = f_number
        camera.lens.film_diagonal_mm = film_diagonal
        if blades:
            camera.lens.blades = blades
        camera.lens.units_per_mm = units_per_mm
        self._place_camera(camera, world_from_camera, clip)

    def cylindrical_camera(
        self,
        world_from_camera: npt.ArrayLike,
        fov: float = 360.0,
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """A panorama in which upright lines are straight; `fov` is across the film's width, in degrees."""
        camera = self._camera()
        camera.cylindrical.fov_degrees = fov
        self._place_camera(camera, world_from_camera, clip)

    def spherical_camera(
        self,
        world_from_camera: npt.ArrayLike,
        mapping: str = "equirectangular",
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """All directions, +y of camera space up; `mapping` is one of SphericalCamera.Mapping. The middle of an
        equirectangular picture looks along -x, its right part along -z."""
        camera = self._camera()
        camera.spherical.mapping = _choice(_SPHERES, mapping, "mapping of a sphere")
        self._place_camera(camera, world_from_camera, clip)

    def _camera(self) -> camera_pb2.Camera:
        """A copy of the camera so far."""
        camera = camera_pb2.Camera()
        camera.CopyFrom(self.message.camera)
        return camera

    def _place_camera(
        self, camera: camera_pb2.Camera, world_from_camera: npt.ArrayLike, clip: tuple[float, float]
    ) -> None:
        camera.world_from_camera.CopyFrom(matrix_message(world_from_camera) or value_pb2.Matrix())
        camera.near_clip, camera.far_clip = clip
        self.message.camera.CopyFrom(checked(camera))

    def film(
        self, width: int, height: int, filter: str = "box", exposure: float | None = None
    ) -> None:
        """Size in pixels; `filter`: box, triangle, gaussian, mitchell or lanczos."""
        film = camera_pb2.Film()
        film.CopyFrom(self.message.film)
        film.width, film.height = width, height
        film.filter.kind = _choice(_FILTERS, filter, "filter")
        if exposure is not None:
            film.exposure = exposure
        self.message.film.CopyFrom(checked(film))

    @property
    def settings(self) -> settings_pb2.RenderSettings:
        """How it is rendered where a job does not say: integrator, spp, noise, max_depth, seed ..."""
        return self.message.settings

    def save(self, path: str | Path) -> None:
        """Writes the scene as `.textproto`, and its blobs into a folder beside it, for `tessera render`."""
        path = Path(path)
        folder = path.with_suffix(".blobs")
        folder.mkdir(parents=True, exist_ok=True)
        checked(self.message)
        names = {}
        for blob in self.blobs.values():
            names[blob.digest] = f"{folder.name}/{blob.digest[:16]}{Path(blob.path).suffix}"
            (path.parent / names[blob.digest]).write_bytes(blob.data)
        written = scene_pb2.Scene()
        written.CopyFrom(self.message)
        _name_files(written, names)
        header = "# proto-file: proto/tessera/v1/scene.proto\n# proto-message: tessera.v1.Scene\n"
        path.write_text(header + text_format.MessageToString(written))


def _name_files(message: object, names: dict[str, str]) -> None:
    """References to blobs name files in place of digests."""
    if isinstance(message, blob_ref_pb2.BlobRef):
        if message.digest in names:
            message.path = names[message.digest]
            message.digest, message.size_bytes = "", 0
        return
    for descriptor, value in message.ListFields():  # type: ignore[attr-defined]
        if descriptor.message_type is None:
            continue
        for part in value if descriptor.label == descriptor.LABEL_REPEATED else [value]:
            _name_files(part, names)
