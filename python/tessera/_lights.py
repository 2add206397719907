"""Lights of scenes; emission of surfaces is the shapes'."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tessera._mesh import encode_pfm
from tessera._scene_message import SceneMessage
from tessera._values import Vector, checked, matrix_message, point_message, spectrum_message
from tessera.v1 import light_pb2, value_pb2


class Lights(SceneMessage):
    """The part of a scene that shines without a surface."""

    def light(self, message: light_pb2.Light) -> None:
        """Any light of the scene language."""
        self.message.lights.append(checked(message))

    def point_light(self, position: Vector, intensity: float | Vector, radius: float = 0.0) -> None:
        """`intensity`: W/sr. With a `radius`, the light comes from a sphere that is no surface: its shadows are
        soft, nothing shows it, and it throws no shadow."""
        kind = light_pb2.PointLight(
            position=point_message(position), intensity=spectrum_message(intensity), radius=radius
        )
        self.light(light_pb2.Light(point=kind))

    def spot_light(
        self,
        position: Vector,
        target: Vector,
        intensity: float | Vector,
        cone_angle: float = 30.0,
        cone_delta: float = 5.0,
        radius: float = 0.0,
    ) -> None:
        """`intensity` on the axis, W/sr; `cone_angle`: half of the cone's, which falls off over its last
        `cone_delta`; `radius` as of `point_light`."""
        kind = light_pb2.SpotLight(
            position=point_message(position),
            target=point_message(target),
            intensity=spectrum_message(intensity),
            cone_angle_degrees=cone_angle,
            cone_delta_degrees=cone_delta,
            radius=radius,
        )
        self.light(light_pb2.Light(spot=kind))

    def distant_light(self, direction: Vector, irradiance: float | Vector) -> None:
        """Travels along `direction`; `irradiance` on a surface that faces it, W/m^2."""
        kind = light_pb2.DistantLight(
            direction=point_message(direction), irradiance=spectrum_message(irradiance)
        )
        self.light(light_pb2.Light(distant=kind))

    def environment(
        self,
        radiance: float | Vector | npt.NDArray[np.floating[Any]] | str | Path,
        scale: float = 1.0,
        world_from_light: npt.ArrayLike | None = None,
    ) -> None:
        """Light from all directions: a colour, or a picture by latitude and longitude as an array (height,
        width, 3) or a file. Light space has y up; the middle of the picture is at +z, a quarter at +x."""
        kind = light_pb2.InfiniteLight(mapping="LATITUDE_LONGITUDE", scale=scale)
        if isinstance(radiance, (str, Path)):
            path = Path(radiance)
            kind.image.CopyFrom(self._add_blob(path.read_bytes(), path.name))
        elif isinstance(radiance, np.ndarray) and radiance.ndim == 3:
            kind.image.CopyFrom(self._add_blob(encode_pfm(radiance), "environment.pfm"))
        else:
            kind.radiance.CopyFrom(spectrum_message(radiance))
        if world_from_light is not None:
            kind.world_from_light.CopyFrom(matrix_message(world_from_light) or value_pb2.Matrix())
        self.light(light_pb2.Light(infinite=kind))
