"""Textures and materials of scenes. What they return is a handle: the name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tessera._mesh import encode_pfm
from tessera._scene_message import SceneMessage
from tessera._values import (
    Color,
    Material,
    Number,
    Texture,
    checked,
    color_message,
    number_message,
    roughness_message,
    spectrum_message,
)
from tessera.v1 import material_pb2, texture_pb2


class Materials(SceneMessage):
    """The part of a scene that says what surfaces are made of."""

    def image_texture(
        self, name: str, image: str | Path | npt.NDArray[np.floating[Any]], srgb: bool | None = None
    ) -> Texture:
        """A texture from a file (.exr .png .jpg .tga .pfm ...), or an array (height, width, 3), rows from the top, which
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
            even=color_message(even), odd=color_message(odd), mapping=mapping
        )
        self.message.textures.append(checked(texture_pb2.Texture(name=name, checkerboard=texture)))
        return Texture(name)

    def material(self, message: material_pb2.Material) -> Material:
        """Any material of the scene language."""
        if any(other.name == message.name for other in self.message.materials):
            raise ValueError(f"there is a material '{message.name}' already")
        self.message.materials.append(checked(message))
        return Material(message.name)

    def diffuse(self, name: str, reflectance: Color) -> Material:
        kind = material_pb2.DiffuseMaterial(reflectance=color_message(reflectance))
        return self.material(material_pb2.Material(name=name, diffuse=kind))

    def conductor(self, name: str, reflectance: Color, roughness: Number | None = None) -> Material:
        """A metal by what it reflects along the normal; `roughness` is GGX's alpha, none a mirror."""
        kind = material_pb2.ConductorMaterial(
            reflectance=color_message(reflectance), roughness=roughness_message(roughness)
        )
        return self.material(material_pb2.Material(name=name, conductor=kind))

    def dielectric(
        self, name: str, ior: float = 1.5, roughness: Number | None = None, tint: Color | None = None
    ) -> Material:
        """Glass and liquids; `tint` is of the light that passes."""
        kind = material_pb2.DielectricMaterial(
            eta=spectrum_message(ior),
            roughness=roughness_message(roughness),
            transmission_tint=color_message(tint),
        )
        return self.material(material_pb2.Material(name=name, dielectric=kind))

    def plastic(
        self, name: str, reflectance: Color, ior: float = 1.5, roughness: Number | None = None
    ) -> Material:
        """A dielectric coat over a diffuse base."""
        kind = material_pb2.CoatedDiffuseMaterial(
            reflectance=color_message(reflectance),
            eta=spectrum_message(ior),
            roughness=roughness_message(roughness),
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
            base_color=color_message(base_color),
            roughness=number_message(roughness),
            metallic=number_message(metallic),
            spec_trans=number_message(transmission),
            clearcoat=number_message(clearcoat),
            clearcoat_gloss=number_message(clearcoat_gloss),
            sheen=number_message(sheen),
            specular=None if specular is None or ior is not None else number_message(specular),
        )
        if ior is not None:
            kind.eta = ior
        return self.material(
            material_pb2.Material(name=name, principled=kind, opacity=number_message(opacity))
        )

    def mix(self, name: str, a: Material, b: Material, amount: Number) -> Material:
        """`b` with probability `amount`, else `a`."""
        kind = material_pb2.MixMaterial(a=a, b=b, amount=number_message(amount))
        return self.material(material_pb2.Material(name=name, mix=kind))
