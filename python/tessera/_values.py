"""Values of the scene language, from Python's: numbers, colours, points, matrices, bytes."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NewType, Tuple, TypeVar, Union

import numpy as np
import numpy.typing as npt
from google.protobuf.message import Message

from tessera.v1 import blob_ref_pb2, light_pb2, material_pb2, value_pb2

Material = NewType("Material", str)
Texture = NewType("Texture", str)
Vector = Union[Sequence[float], npt.NDArray[np.floating[Any]]]
Color = Union[float, Vector, Texture]  # grey, or three numbers, or what varies over the surface
Number = Union[float, Texture]
Amount = Tuple[float, str]  # a value and its unit: (800, "lm")


@dataclass(frozen=True)
class Blob:
    """Bytes that a scene refers to, by their digest."""

    data: bytes
    digest: str
    path: str  # a hint of the format

    @staticmethod
    def of(data: bytes, path: str) -> Blob:
        return Blob(data, hashlib.sha256(data).hexdigest(), path)

    def ref(self) -> blob_ref_pb2.BlobRef:
        return blob_ref_pb2.BlobRef(digest=self.digest, size_bytes=len(self.data), path=self.path)


AnyMessage = TypeVar("AnyMessage", bound=Message)
_Kind = TypeVar("_Kind")


def choice(choices: dict[str, _Kind], name: str, what: str) -> _Kind:
    """The kind of this name; ValueError, with all names, where there is none."""
    if name not in choices:
        raise ValueError(f"there is no {what} '{name}'; there are {', '.join(choices)}")
    return choices[name]


def checked(message: AnyMessage) -> AnyMessage:
    """The message, if all of its numbers are finite; else a ValueError that names the field."""
    for place, number in _numbers(message, message.DESCRIPTOR.name):
        if not math.isfinite(number):
            raise ValueError(f"{place}: expected a finite number that fits into 32 bits, not {number}")
    return message


def _numbers(message: Message, place: str) -> Iterator[tuple[str, float]]:
    for field, value in message.ListFields():
        many = field.label == field.LABEL_REPEATED
        for part in value if many else [value]:
            if field.cpp_type == field.CPPTYPE_MESSAGE:
                yield from _numbers(part, f"{place}.{field.name}")
            elif field.cpp_type in (field.CPPTYPE_FLOAT, field.CPPTYPE_DOUBLE):
                yield f"{place}.{field.name}", part


def spectrum_message(color: float | Vector) -> value_pb2.Spectrum:
    if isinstance(color, (int, float)):
        return value_pb2.Spectrum(constant=float(color))
    r, g, b = (float(c) for c in color)
    return value_pb2.Spectrum(rgb=value_pb2.Rgb(r=r, g=g, b=b))


def amount_message(amount: Amount) -> light_pb2.LightAmount:
    """How bright a light is; ValueError for values below 0."""
    value, unit = amount
    if not value >= 0:
        raise ValueError(f"an amount of light is 0 or more, not {value} {unit}")
    return light_pb2.LightAmount(value=float(value), unit=unit)


def color_message(color: Color | None) -> value_pb2.SpectrumValue | None:
    if color is None:
        return None
    if isinstance(color, str):
        return value_pb2.SpectrumValue(texture=color)
    return value_pb2.SpectrumValue(constant=spectrum_message(color))


def number_message(number: Number | None) -> value_pb2.FloatValue | None:
    if number is None:
        return None
    if isinstance(number, str):
        return value_pb2.FloatValue(texture=number)
    return value_pb2.FloatValue(constant=float(number))


def point_message(point: Vector) -> value_pb2.Point3:
    x, y, z = (float(c) for c in point)
    return value_pb2.Point3(x=x, y=y, z=z)


def matrix_message(matrix: npt.ArrayLike | None) -> value_pb2.Matrix | None:
    if matrix is None:
        return None
    array = np.asarray(matrix, dtype=np.float64)
    if array.shape != (4, 4) or not np.isfinite(array).all():
        raise ValueError(f"expected a matrix of 4 x 4 finite numbers, not {array.shape}")
    return value_pb2.Matrix(elements=[float(element) for element in array.ravel()])


def roughness_message(roughness: Number | None) -> material_pb2.Roughness | None:
    if roughness is None:
        return None
    return material_pb2.Roughness(u=number_message(roughness), v=number_message(roughness))


def look_at(eye: Vector, target: Vector, up: Vector = (0, 1, 0)) -> npt.NDArray[np.float64]:
    """World from camera in a right-handed world: a camera at `eye` that looks at `target`."""
    position = np.asarray(eye, dtype=np.float64)
    forward = np.asarray(target, dtype=np.float64) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, np.asarray(up, dtype=np.float64))
    if not np.linalg.norm(right) > 0:
        raise ValueError("look_at: `up` is the direction of view, or one of them is nothing")
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = right, np.cross(right, forward), forward
    matrix[:3, 3] = position
    return matrix


def translate(x: float, y: float, z: float) -> npt.NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix
