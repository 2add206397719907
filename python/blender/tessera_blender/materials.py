"""Blender's materials as Tessera's (the table of docs/python.md). What has no counterpart is named in `warnings`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
from tessera import Material, Scene, Texture


# Names of inputs since Blender 4.0.
_NEW_NAMES = {
    "Subsurface": "Subsurface Weight",
    "Specular": "Specular IOR Level",
    "Transmission": "Transmission Weight",
    "Clearcoat": "Coat Weight",
    "Clearcoat Roughness": "Coat Roughness",
    "Sheen": "Sheen Weight",
    "Emission": "Emission Color",
}


class Surface:
    """The meaning of a material slot: how the surface scatters, and the radiance that it emits, if any;
    `is_seen`: there is a surface at all."""

    def __init__(self, material: Material | None, emission: Any = None, is_seen: bool = True) -> None:
        self.material = material
        self.emission = emission
        self.is_seen = is_seen


def input_of(node: Any, name: str) -> Any:
    """The node's input, by its name in Blender 3.4."""
    new = _NEW_NAMES.get(name, name)
    return node.inputs[new if new in node.inputs else name]


def _linear(encoded: Any) -> Any:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


class Materials:
    """Translates each material and each picture once."""

    def __init__(self, scene: Scene, warnings: list[str]) -> None:
        self._scene = scene
        self._warnings = warnings
        self._surfaces: dict[str, Surface] = {}
        self._textures: dict[tuple[str, bool], Texture] = {}

    def warn(self, text: str) -> None:
        if text not in self._warnings:
            self._warnings.append(text)

    def surface(self, material: Any) -> Surface:
        if material is None:
            return Surface(None)
        if material.name not in self._surfaces:
            self._surfaces[material.name] = self._translate(material)
        return self._surfaces[material.name]

    def _translate(self, material: Any) -> Surface:
        output = None
        if material.use_nodes and material.node_tree:
            output = material.node_tree.get_output_node("CYCLES") or material.node_tree.get_output_node("ALL")
        if output is None:
            return Surface(self._scene.diffuse(material.name, material.diffuse_color[:3]))
        for socket in ("Volume", "Displacement"):
            if output.inputs[socket].is_linked:
                self.warn(f"material {material.name}: its {socket.lower()} is left out")
        surface = output.inputs["Surface"]
        if not surface.is_linked and output.inputs["Volume"].is_linked:
            return Surface(None, is_seen=False)
        if not surface.is_linked:
            return Surface(self._scene.diffuse(material.name, 0.0))
        return self._shader(material, surface.links[0].from_node, material.name)

    def _shader(self, material: Any, node: Any, name: str) -> Surface:
        translate = {
            "BSDF_PRINCIPLED": self._principled,
            "BSDF_DIFFUSE": self._diffuse,
            "BSDF_GLOSSY": self._glossy,
            "BSDF_GLASS": self._glass,
            "EMISSION": self._emission,
        }.get(node.type)
        if translate is None:
            self.warn(
                f"material {material.name}: node '{node.name}' ({node.bl_label}) is not known; it is diffuse, in "
                "the viewport's colour"
            )
            return Surface(self._scene.diffuse(name, material.diffuse_color[:3]))
        return translate(material, node, name)

    # ---- shaders

    def _principled(self, material: Any, node: Any, name: str) -> Surface:
        def value(socket: str) -> Any:
            return self._value(material, node, socket)

        transmission = value("Transmission")
        clear = transmission != 0.0
        made = self._scene.principled(
            name,
            base_color=self._color(material, node, "Base Color"),
            roughness=value("Roughness"),
            metallic=value("Metallic"),
            specular=None if clear else self._specular(material, node),
            ior=float(node.inputs["IOR"].default_value) if clear else None,
            transmission=transmission,
            clearcoat=value("Clearcoat"),
            clearcoat_gloss=1.0 - float(input_of(node, "Clearcoat Roughness").default_value),
            sheen=value("Sheen"),
            opacity=self._opacity(material, node),
        )
        for socket in ("Subsurface", "Anisotropic"):
            if input_of(node, socket).is_linked or input_of(node, socket).default_value:
                self.warn(f"material {material.name}: {socket.lower()} of '{node.name}' is left out")
        self._bend(material, node, name)
        strength = float(node.inputs["Emission Strength"].default_value)
        emission = self._color(material, node, "Emission") if strength else None
        return Surface(made, self._radiance(material, emission, strength))

    def _specular(self, material: Any, node: Any) -> Any:
        """Burley's: reflectance along the normal over 0.08. Since Blender 4.0 that of the IOR is scaled."""
        level = self._value(material, node, "Specular")
        if "Specular IOR Level" not in node.inputs:
            return level
        ior = float(node.inputs["IOR"].default_value)
        scale = 25 * ((ior - 1) / (ior + 1)) ** 2
        if isinstance(level, str):
            if abs(scale - 1) > 0.01:
                self.warn(f"material {material.name}: a textured specular level is of IOR 1.5")
            return level
        return scale * level

    def _diffuse(self, material: Any, node: Any, name: str) -> Surface:
        if node.inputs["Roughness"].is_linked or node.inputs["Roughness"].default_value:
            self.warn(f"material {material.name}: '{node.name}' is Lambertian, without roughness")
        made = self._scene.diffuse(name, self._color(material, node, "Color"))
        self._bend(material, node, name)
        return Surface(made)

    def _glossy(self, material: Any, node: Any, name: str) -> Surface:
        alpha = self._alpha(material, node)
        return Surface(self._scene.conductor(name, self._color(material, node, "Color"), alpha))

    def _glass(self, material: Any, node: Any, name: str) -> Surface:
        ior = float(node.inputs["IOR"].default_value)
        tint = self._color(material, node, "Color")
        return Surface(self._scene.dielectric(name, ior, self._alpha(material, node), tint))

    def _emission(self, material: Any, node: Any, name: str) -> Surface:
        strength = float(node.inputs["Strength"].default_value)
        emission = self._color(material, node, "Color")
        black = self._scene.diffuse(name, 0.0)
        return Surface(black, self._radiance(material, emission, strength))

    # ---- inputs

    def _alpha(self, material: Any, node: Any) -> float | None:
        """GGX's alpha of Blender's roughness, its square; None: perfectly smooth."""
        if node.inputs["Roughness"].is_linked:
            self.warn(f"material {material.name}: the roughness of '{node.name}' has its own value, no texture")
        roughness = float(node.inputs["Roughness"].default_value)
        return roughness**2 if roughness > 0 and node.distribution != "SHARP" else None

    def _opacity(self, material: Any, node: Any) -> Any:
        alpha = self._value(material, node, "Alpha")
        return None if alpha == 1.0 else alpha

    def _radiance(self, material: Any, color: Any, strength: float) -> Any:
        if color is None or strength == 0:
            return None
        if isinstance(color, str):
            if strength != 1:
                self.warn(f"material {material.name}: a textured emission has strength 1")
            return color
        radiance = [strength * c for c in color]
        return radiance if any(radiance) else None

    def _value(self, material: Any, node: Any, socket: str) -> Any:
        found = self._linked(material, node, socket)
        return float(input_of(node, socket).default_value) if found is None else found

    def _color(self, material: Any, node: Any, socket: str) -> Any:
        found = self._linked(material, node, socket)
        return list(input_of(node, socket).default_value)[:3] if found is None else found

    def _linked(self, material: Any, node: Any, socket: str) -> Any:
        """The node that is linked to the socket, if that is known; else a warning, and the socket's own value."""
        if not input_of(node, socket).is_linked:
            return None
        source = input_of(node, socket).links[0].from_node
        if source.type == "TEX_IMAGE" and source.image is not None:
            if source.inputs["Vector"].is_linked and source.inputs["Vector"].links[0].from_node.type != "UVMAP":
                self.warn(f"material {material.name}: the mapping of '{source.name}' is left out")
            return self._texture(source.image)
        if source.type == "RGB":
            return list(source.outputs[0].default_value)[:3]
        if source.type == "VALUE":
            return float(source.outputs[0].default_value)
        self.warn(
            f"material {material.name}: '{source.name}' ({source.bl_label}) at {socket.lower()} of "
            f"'{node.name}' is not known; its own value is taken"
        )
        return None

    def _bend(self, material: Any, node: Any, name: str) -> None:
        if not node.inputs["Normal"].is_linked:
            return
        source = node.inputs["Normal"].links[0].from_node
        picture = source.inputs["Color"].links if source.type == "NORMAL_MAP" else []
        if source.type != "NORMAL_MAP" or not picture or picture[0].from_node.type != "TEX_IMAGE":
            self.warn(f"material {material.name}: '{source.name}' ({source.bl_label}) bends nothing")
            return
        if source.inputs["Strength"].default_value != 1:
            self.warn(f"material {material.name}: the normal map has strength 1")
        texture = self._texture(picture[0].from_node.image, data=True)
        made = next(other for other in self._scene.message.materials if other.name == name)
        made.normal_texture = texture

    def _texture(self, image: Any, data: bool = False) -> Texture:
        """A picture as a texture; `data`: its numbers are no colours."""
        is_srgb = image.colorspace_settings.name == "sRGB" and not data
        key = (image.name, is_srgb)
        if key not in self._textures:
            name = f"{image.name}{'' if is_srgb else ' (linear)'}"
            path = Path(bpy.path.abspath(image.filepath_from_user())) if image.filepath else None
            plain = image.source == "FILE" and not image.packed_file and not image.is_dirty
            if plain and path is not None and path.is_file():
                self._textures[key] = self._scene.image_texture(name, path, None if image.is_float else is_srgb)
            else:
                self._textures[key] = self._scene.image_texture(name, self._pixels(image, is_srgb))
        return self._textures[key]

    def _pixels(self, image: Any, is_srgb: bool) -> Any:
        """(height, width, 3), linear, rows from the top."""
        width, height = image.size
        flat = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(flat)
        pixels = flat.reshape(height, width, image.channels)[::-1]
        bands = pixels[..., :3] if image.channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
        return _linear(bands) if is_srgb and not image.is_float else bands
