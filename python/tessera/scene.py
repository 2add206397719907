"""Scenes that are built in code.

A `Scene` fills a message of Tessera's scene language (proto/tessera/v1/scene.proto), which is open to whoever
wants more than the functions here: `scene.message`. Spaces: world space is any, right-handed or not; matrices are
4 x 4 and act on column vectors; angles are in degrees; colours are linear Rec.709.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NewType, Union

import numpy as np
import numpy.typing as npt
from google.protobuf import text_format

from tessera._mesh import encode_mesh, encode_pfm
from tessera.v1 import (
    blob_ref_pb2,
    camera_pb2,
    light_pb2,
    material_pb2,
    scene_pb2,
    settings_pb2,
    shape_pb2,
    texture_pb2,
    value_pb2,
)

Material = NewType("Material", str)
Texture = NewType("Texture", str)
Vector = Union[Sequence[float], npt.NDArray[np.floating[Any]]]
Color = Union[float, Vector, Texture]  # grey, or three numbers, or what varies over the surface
Number = Union[float, Texture]

_FILTERS = {kind.lower(): number for kind, number in camera_pb2.PixelFilter.Kind.items()}


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


def _spectrum(color: float | Vector) -> value_pb2.Spectrum:
    if isinstance(color, (int, float)):
        return value_pb2.Spectrum(constant=float(color))
    r, g, b = (float(c) for c in color)
    return value_pb2.Spectrum(rgb=value_pb2.Rgb(r=r, g=g, b=b))


def _color(color: Color | None) -> value_pb2.SpectrumValue | None:
    if color is None:
        return None
    if isinstance(color, str):
        return value_pb2.SpectrumValue(texture=color)
    return value_pb2.SpectrumValue(constant=_spectrum(color))


def _number(number: Number | None) -> value_pb2.FloatValue | None:
    if number is None:
        return None
    if isinstance(number, str):
        return value_pb2.FloatValue(texture=number)
    return value_pb2.FloatValue(constant=float(number))


def _point(point: Vector) -> value_pb2.Point3:
    x, y, z = (float(c) for c in point)
    return value_pb2.Point3(x=x, y=y, z=z)


def _matrix(matrix: npt.ArrayLike | None) -> value_pb2.Matrix | None:
    if matrix is None:
        return None
    array = np.asarray(matrix, dtype=np.float64)
    if array.shape != (4, 4) or not np.isfinite(array).all():
        raise ValueError(f"expected a matrix of 4 x 4 finite numbers, not {array.shape}")
    return value_pb2.Matrix(elements=[float(element) for element in array.ravel()])


def _roughness(roughness: Number | None) -> material_pb2.Roughness | None:
    if roughness is None:
        return None
    return material_pb2.Roughness(u=_number(roughness), v=_number(roughness))


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


class Scene:
    """A scene, and the bytes of its meshes and pictures. Materials and textures are handles: their names."""

    def __init__(self, name: str = "scene") -> None:
        self.message = scene_pb2.Scene(name=name)
        self.blobs: dict[str, Blob] = {}  # by digest

    # ---- camera, film, settings

    def camera(
        self,
        world_from_camera: npt.ArrayLike,
        fov: float = 50.0,
        lens_radius: float = 0.0,
        focal_distance: float = 0.0,
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """A perspective camera (`look_at`); `fov` is across the film's shorter side. Camera space has x to
        the right, y up, and z into the scene."""
        self.message.camera.perspective.fov_degrees = fov
        self.message.camera.perspective.lens_radius = lens_radius
        self.message.camera.perspective.focal_distance = focal_distance
        self._place_camera(world_from_camera, clip)

    def orthographic_camera(
        self,
        world_from_camera: npt.ArrayLike,
        screen_window: tuple[float, float, float, float],
        clip: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Parallel rays through x_min, x_max, y_min, y_max of camera space."""
        self.message.camera.orthographic.SetInParent()
        self.message.camera.screen_window[:] = screen_window
        self._place_camera(world_from_camera, clip)

    def _place_camera(self, world_from_camera: npt.ArrayLike, clip: tuple[float, float]) -> None:
        camera = self.message.camera
        camera.world_from_camera.CopyFrom(_matrix(world_from_camera) or value_pb2.Matrix())
        camera.near_clip, camera.far_clip = clip

    def film(
        self, width: int, height: int, filter: str = "box", exposure: float | None = None
    ) -> None:
        """Size in pixels; `filter`: box, triangle, gaussian, mitchell or lanczos."""
        if filter not in _FILTERS:
            raise ValueError(f"there is no filter '{filter}'; there are {', '.join(_FILTERS)}")
        self.message.film.width, self.message.film.height = width, height
        self.message.film.filter.kind = _FILTERS[filter]
        if exposure is not None:
            self.message.film.exposure = exposure

    @property
    def settings(self) -> settings_pb2.RenderSettings:
        """How it is rendered where a job does not say: integrator, spp, noise, max_depth, seed ..."""
        return self.message.settings

    # ---- textures

    def _add_blob(self, data: bytes, path: str) -> blob_ref_pb2.BlobRef:
        blob = Blob.of(data, path)
        self.blobs.setdefault(blob.digest, blob)
        return blob.ref()

    def image_texture(
        self, name: str, image: str | Path | npt.NDArray[np.floating[Any]], srgb: bool | None = None
    ) -> Texture:
        """Of a file (.exr .png .jpg .tga .pfm ...), or an array (height, width, 3), rows from the top, which
        is linear. `srgb`: whether the file's numbers are; None: as its format has it."""
        texture = texture_pb2.ImageTexture()
        if isinstance(image, (str, Path)):
            path = Path(image)
            texture.image.CopyFrom(self._add_blob(path.read_bytes(), path.name))
        else:
            texture.image.CopyFrom(self._add_blob(encode_pfm(image), f"{name}.pfm"))
        if srgb is not None:
            encodings = texture_pb2.ImageTexture.Encoding
            texture.encoding = encodings.Value("SRGB" if srgb else "LINEAR")
        self.message.textures.append(texture_pb2.Texture(name=name, image=texture))
        return Texture(name)

    def checkerboard(
        self, name: str, even: Color, odd: Color, scale: tuple[float, float] = (1.0, 1.0)
    ) -> Texture:
        mapping = texture_pb2.UvMapping(scale_u=scale[0], scale_v=scale[1])
        texture = texture_pb2.CheckerboardTexture(
            even=_color(even), odd=_color(odd), mapping=mapping
        )
        self.message.textures.append(texture_pb2.Texture(name=name, checkerboard=texture))
        return Texture(name)

    # ---- materials

    def material(self, message: material_pb2.Material) -> Material:
        """Any material of the scene language."""
        if any(other.name == message.name for other in self.message.materials):
            raise ValueError(f"there is a material '{message.name}' already")
        self.message.materials.append(message)
        return Material(message.name)

    def diffuse(self, name: str, reflectance: Color) -> Material:
        kind = material_pb2.DiffuseMaterial(reflectance=_color(reflectance))
        return self.material(material_pb2.Material(name=name, diffuse=kind))

    def conductor(self, name: str, reflectance: Color, roughness: Number | None = None) -> Material:
        """A metal by what it reflects along the normal; `roughness` is GGX's alpha, none a mirror."""
        kind = material_pb2.ConductorMaterial(
            reflectance=_color(reflectance), roughness=_roughness(roughness)
        )
        return self.material(material_pb2.Material(name=name, conductor=kind))

    def dielectric(
        self, name: str, ior: float = 1.5, roughness: Number | None = None, tint: Color | None = None
    ) -> Material:
        """Glass and liquids; `tint` is of the light that passes."""
        kind = material_pb2.DielectricMaterial(
            eta=_spectrum(ior), roughness=_roughness(roughness), transmission_tint=_color(tint)
        )
        return self.material(material_pb2.Material(name=name, dielectric=kind))

    def plastic(
        self, name: str, reflectance: Color, ior: float = 1.5, roughness: Number | None = None
    ) -> Material:
        """A dielectric coat over a diffuse base."""
        kind = material_pb2.CoatedDiffuseMaterial(
            reflectance=_color(reflectance), eta=_spectrum(ior), roughness=_roughness(roughness)
        )
        return self.material(material_pb2.Material(name=name, coated_diffuse=kind))

    def principled(
        self,
        name: str,
        base_color: Color = 0.5,
        roughness: Number = 0.5,
        metallic: Number = 0.0,
        specular: Number | None = None,
        transmission: Number = 0.0,
        ior: float | None = None,
        clearcoat: Number = 0.0,
        clearcoat_gloss: Number = 1.0,
        sheen: Number = 0.0,
        opacity: Number | None = None,
    ) -> Material:
        """Burley's model [2012, 2015]; `ior` stands instead of `specular`."""
        kind = material_pb2.PrincipledMaterial(
            base_color=_color(base_color),
            roughness=_number(roughness),
            metallic=_number(metallic),
            spec_trans=_number(transmission),
            clearcoat=_number(clearcoat),
            clearcoat_gloss=_number(clearcoat_gloss),
            sheen=_number(sheen),
            specular=None if specular is None or ior is not None else _number(specular),
        )
        if ior is not None:
            kind.eta = ior
        return self.material(
            material_pb2.Material(name=name, principled=kind, opacity=_number(opacity))
        )

    def mix(self, name: str, a: Material, b: Material, amount: Number) -> Material:
        """`b` with probability `amount`, else `a`."""
        kind = material_pb2.MixMaterial(a=a, b=b, amount=_number(amount))
        return self.material(material_pb2.Material(name=name, mix=kind))

    # ---- shapes

    def shape(
        self,
        message: shape_pb2.Shape,
        material: Material | None = None,
        transform: npt.ArrayLike | None = None,
        emission: Color | None = None,
        two_sided: bool = False,
        name: str = "",
        to: scene_pb2.Object | None = None,
    ) -> shape_pb2.Shape:
        """Adds any shape of the scene language to the scene, or `to` an object. `transform`: world from
        object; `emission`: radiance on the side of the normal, or on both."""
        message.material = material or ""
        message.name = name
        if transform is not None:
            message.world_from_object.CopyFrom(_matrix(transform) or value_pb2.Matrix())
        if emission is not None:
            textured = isinstance(emission, str)
            message.area_light.radiance.CopyFrom(_spectrum(1.0 if isinstance(emission, str) else emission))
            message.area_light.texture = str(emission) if textured else ""
            message.area_light.two_sided = two_sided
        shapes = self.message.shapes if to is None else to.shapes
        shapes.append(message)
        added: shape_pb2.Shape = shapes[-1]  # a copy
        return added

    def mesh(
        self,
        vertices: npt.ArrayLike,
        triangles: npt.ArrayLike,
        material: Material | None = None,
        *,
        normals: npt.ArrayLike | None = None,
        uvs: npt.ArrayLike | None = None,
        transform: npt.ArrayLike | None = None,
        emission: Color | None = None,
        two_sided: bool = False,
        name: str = "",
        to: scene_pb2.Object | None = None,
    ) -> shape_pb2.Shape:
        """Triangles: `vertices` (n, 3), `triangles` (m, 3) with indices of vertices, which run counterclockwise
        seen from outside; `normals` (n, 3) and `uvs` (n, 2), v upwards from the picture's lower edge."""
        blob = self._add_blob(encode_mesh(vertices, triangles, normals, uvs), f"{name or 'mesh'}.mesh")
        message = shape_pb2.Shape(mesh=shape_pb2.TriangleMesh(blob=blob))
        return self.shape(message, material, transform, emission, two_sided, name, to)

    def sphere(
        self,
        radius: float,
        center: Vector = (0, 0, 0),
        material: Material | None = None,
        emission: Color | None = None,
        name: str = "",
    ) -> shape_pb2.Shape:
        message = shape_pb2.Shape(sphere=shape_pb2.Sphere(radius=radius))
        x, y, z = (float(c) for c in center)
        return self.shape(message, material, translate(x, y, z), emission, name=name)

    def box(
        self, low: Vector, high: Vector, material: Material | None = None, name: str = ""
    ) -> shape_pb2.Shape:
        message = shape_pb2.Shape(
            box=shape_pb2.Box(low=[float(c) for c in low], high=[float(c) for c in high])
        )
        return self.shape(message, material, name=name)

    def rectangle(
        self,
        corners: Sequence[Vector],
        material: Material | None = None,
        emission: Color | None = None,
        two_sided: bool = False,
        name: str = "",
    ) -> shape_pb2.Shape:
        """A polygon, its corners counterclockwise about its normal; u goes along its first edge."""
        flat = [float(c) for corner in corners for c in corner]
        message = shape_pb2.Shape(polygon=shape_pb2.Polygon(corners=flat))
        return self.shape(message, material, None, emission, two_sided, name)

    def object(self, name: str) -> scene_pb2.Object:
        """A group of shapes (`to`), placed by `instance`."""
        self.message.objects.append(scene_pb2.Object(name=name))
        added: scene_pb2.Object = self.message.objects[-1]
        return added

    def instance(self, object: scene_pb2.Object, world_from_instance: npt.ArrayLike) -> None:
        self.message.instances.append(
            scene_pb2.Instance(object=object.name, world_from_instance=_matrix(world_from_instance))
        )

    # ---- lights

    def light(self, message: light_pb2.Light) -> None:
        """Any light of the scene language."""
        self.message.lights.append(message)

    def point_light(self, position: Vector, intensity: float | Vector) -> None:
        """`intensity`: W/sr"""
        kind = light_pb2.PointLight(position=_point(position), intensity=_spectrum(intensity))
        self.light(light_pb2.Light(point=kind))

    def spot_light(
        self,
        position: Vector,
        target: Vector,
        intensity: float | Vector,
        cone_angle: float = 30.0,
        cone_delta: float = 5.0,
    ) -> None:
        """`intensity` on the axis, W/sr; `cone_angle`: half of the cone's, which falls off over its last
        `cone_delta`."""
        kind = light_pb2.SpotLight(
            position=_point(position),
            target=_point(target),
            intensity=_spectrum(intensity),
            cone_angle_degrees=cone_angle,
            cone_delta_degrees=cone_delta,
        )
        self.light(light_pb2.Light(spot=kind))

    def distant_light(self, direction: Vector, irradiance: float | Vector) -> None:
        """Travels along `direction`; `irradiance` on a surface that faces it, W/m^2."""
        kind = light_pb2.DistantLight(
            direction=_point(direction), irradiance=_spectrum(irradiance)
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
            kind.radiance.CopyFrom(_spectrum(radiance))
        if world_from_light is not None:
            kind.world_from_light.CopyFrom(_matrix(world_from_light) or value_pb2.Matrix())
        self.light(light_pb2.Light(infinite=kind))

    # ---- files

    def save(self, path: str | Path) -> None:
        """Writes the scene as `.textproto`, and its blobs into a folder beside it, for `tessera render`."""
        path = Path(path)
        folder = path.with_suffix(".blobs")
        folder.mkdir(parents=True, exist_ok=True)
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
