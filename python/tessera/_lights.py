"""Lights of scenes; emission of surfaces is the shapes'."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tessera._mesh import encode_pfm
from tessera._scene_message import SceneMessage
from tessera._values import (
    Amount,
    Vector,
    amount_message,
    checked,
    matrix_message,
    point_message,
    spectrum_message,
)
from tessera.v1 import light_pb2, value_pb2


class Lights(SceneMessage):
    """The part of a scene that shines without a surface."""

    def units(self, metres: float | None = None, cd_per_m2: float | None = None) -> None:
        """What numbers of the scene stand for: the length of its unit, and the luminance of a radiance whose
        luminance is 1 (683 where nothing is said). Lights in lm and cd, and photometric files, need the length."""
        for name, value in (("metres", metres), ("cd_per_m2", cd_per_m2)):
            if value is None:
                continue
            if not 0 < value < float("inf"):
                raise ValueError(f"{name}: expected a number above 0, not {value}")
            setattr(self.message.units, name, value)

    def light(self, message: light_pb2.Light, amount: Amount | None = None) -> None:
        """Any light of the scene language. `amount`: how bright it is, in place of what its spectrum says, such
        as (800, "lm"), (300, "cd") or (1000, "lx"); docs/units-of-light.md has all units."""
        if amount is not None:
            message.amount.CopyFrom(amount_message(amount))
        self.message.lights.append(checked(message))

    def point_light(
        self,
        position: Vector,
        intensity: float | Vector = 1.0,
        radius: float = 0.0,
        amount: Amount | None = None,
    ) -> None:
        """`intensity`: W/sr, or the colour alone where there is an `amount` ("lm", "cd", "W" or "W/sr"). With a
        `radius`, the light comes from a sphere that is no surface: its shadows are soft, nothing shows it, and it
        throws no shadow."""
        kind = light_pb2.PointLight(
            position=point_message(position), intensity=spectrum_message(intensity), radius=radius
        )
        self.light(light_pb2.Light(point=kind), amount)

    def photometric_light(
        self,
        file: str | Path | bytes,
        world_from_light: npt.ArrayLike | None = None,
        color: float | Vector = 1.0,
        scale: float = 1.0,
        amount: Amount | None = None,
    ) -> None:
        """A lamp that shines as an IES or EULUMDAT file (or its bytes) says, times `scale` or as bright as
        `amount`. Light space has gamma 0, mostly downwards, along -z, and plane C0 along +x."""
        kind = light_pb2.GoniometricLight(intensity=spectrum_message(color))
        if world_from_light is not None:
            kind.world_from_light.CopyFrom(matrix_message(world_from_light) or value_pb2.Matrix())
        message = light_pb2.Light(goniometric=kind, scale=scale)
        checked(message)
        name = "lamp.ies" if isinstance(file, bytes) else Path(file).name
        data = file if isinstance(file, bytes) else Path(file).read_bytes()
        message.goniometric.photometric_file.CopyFrom(self._add_blob(data, name))
        self.light(message, amount)

    def spot_light(
        self,
        position: Vector,
        target: Vector,
        intensity: float | Vector = 1.0,
        cone_angle: float = 30.0,
        cone_delta: float = 5.0,
        radius: float = 0.0,
        amount: Amount | None = None,
    ) -> None:
        """`intensity` on the axis, W/sr, or the colour alone where there is an `amount`; `cone_angle`: half of the
        cone's, which falls off over its last `cone_delta`; `radius` as of `point_light`."""
        kind = light_pb2.SpotLight(
            position=point_message(position),
            target=point_message(target),
            intensity=spectrum_message(intensity),
            cone_angle_degrees=cone_angle,
            cone_delta_degrees=cone_delta,
            radius=radius,
        )
        self.light(light_pb2.Light(spot=kind), amount)

    def distant_light(
        self, direction: Vector, irradiance: float | Vector = 1.0, amount: Amount | None = None
    ) -> None:
        """Travels along `direction`; `irradiance` on a surface that faces it, W/m^2, or the colour alone where
        there is an `amount` ("lx" or "W/m2")."""
        kind = light_pb2.DistantLight(
            direction=point_message(direction), irradiance=spectrum_message(irradiance)
        )
        self.light(light_pb2.Light(distant=kind), amount)

    def environment(
        self,
        radiance: float | Vector | npt.NDArray[np.floating[Any]] | str | Path,
        scale: float = 1.0,
        world_from_light: npt.ArrayLike | None = None,
        amount: Amount | None = None,
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
        self.light(light_pb2.Light(infinite=kind), amount)

    def daylight(
        self,
        cie_type: int | None = None,
        *,
        perez: tuple[float, float] | None = None,
        toward_sun: Vector | None = None,
        when: datetime | None = None,
        place: tuple[float, float] | None = None,
        diffuse_illuminance: float | None = None,
        sun_illuminance: float | None = None,
        ground_reflectance: float | None = None,
        sun_degrees: float | None = None,
        north_degrees: float = 0.0,
        y_up: bool = False,
        dew_point: float | None = None,
        resolution: int = 0,
        name: str = "",
    ) -> None:
        """The sky, the sun and the ground. Either `cie_type`, 1 to 16, or `perez`: irradiance by the sun, of a
        surface that faces it, and by the sky, of a horizontal one, W/m^2. The sun is at `toward_sun`, or where
        it is at a moment, which has a time zone, at a `place` of latitude and longitude in degrees. Illuminances
        are lx, by default those that are typical. `north_degrees`: from +y (where y is up: -z) clockwise."""
        if (cie_type is None) == (perez is None):
            raise ValueError("daylight: expected either cie_type or perez")
        kind = light_pb2.SkyLight(north_degrees=north_degrees, y_up=y_up, resolution=resolution)
        if cie_type is not None:
            kind.cie_type = cie_type
        if perez is not None:
            kind.perez.direct_normal_irradiance, kind.perez.diffuse_horizontal_irradiance = perez
            if dew_point is not None:
                kind.perez.dew_point_celsius = dew_point
        if toward_sun is not None:
            kind.toward_sun.CopyFrom(point_message(toward_sun))
        if when is not None:
            kind.when.CopyFrom(_place_and_time(when, place))
        for field, value in (
            ("diffuse_horizontal_illuminance", diffuse_illuminance),
            ("sun_normal_illuminance", sun_illuminance),
            ("ground_reflectance", ground_reflectance),
            ("sun_degrees", sun_degrees),
        ):
            if value is not None:
                setattr(kind, field, value)
        self.light(light_pb2.Light(sky=kind, name=name))


def _place_and_time(when: datetime, place: tuple[float, float] | None) -> light_pb2.SkyLight.PlaceAndTime:
    offset = when.utcoffset()
    if offset is None or place is None:
        raise ValueError("daylight: a moment needs a time zone, and a place")
    return light_pb2.SkyLight.PlaceAndTime(
        latitude_degrees=place[0],
        longitude_degrees=place[1],
        utc_offset_hours=offset.total_seconds() / 3600,
        year=when.year,
        month=when.month,
        day=when.day,
        hour=when.hour + when.minute / 60 + (when.second + when.microsecond / 1e6) / 3600,
    )
