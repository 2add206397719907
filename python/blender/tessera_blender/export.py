"""Blender's view as a scene of Tessera: evaluated meshes, lamps, world and camera, without files between."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from tessera import Scene

from .camera import CameraExport
from .materials import Materials
from .motion import Motions, SetFrame, Shutter, write_keys
from .motion import array_of as _array

_SURFACES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


def _unscaled(matrix: Any) -> Any:
    """The same place and directions, without scale: lamps and cameras have their sizes from their data."""
    array = _array(matrix)
    lengths = np.linalg.norm(array[:3, :3], axis=0)
    array[:3, :3] /= np.where(lengths > 0, lengths, 1)
    return array


def _key_of(thing: tuple[tuple[str, tuple[int, ...]], Any, Any]) -> tuple[str, tuple[int, ...]]:
    return thing[0]


# Modifiers whose outcome changes from frame to frame.
_MOVERS = {"ARMATURE", "BUILD", "CLOTH", "DYNAMIC_PAINT", "EXPLODE", "FLUID", "MESH_SEQUENCE_CACHE"}
_MOVERS |= {"OCEAN", "SOFT_BODY", "SURFACE", "WAVE"}


def _is_animated(data: Any) -> bool:
    animation = getattr(data, "animation_data", None)
    return animation is not None and bool(animation.action or animation.drivers or animation.nla_tracks)


def _moves(thing: Any) -> bool:
    """Whether the object may move or change its shape while the shutter is open."""
    above = thing
    while above is not None:
        if _is_animated(above) or above.constraints or above.rigid_body:
            return True
        above = above.parent
    return _changes_shape(thing)


def _changes_shape(thing: Any) -> bool:
    keys = getattr(thing.data, "shape_keys", None)
    movers = any(modifier.type in _MOVERS for modifier in thing.modifiers)
    return movers or _is_animated(thing.data) or _is_animated(keys)


def _instance_key(instance: Any) -> tuple[str, tuple[int, ...]]:
    return instance.object.name, tuple(instance.persistent_id) if instance.is_instance else ()


def _material(evaluated: Any, slot: int) -> Any:
    materials = [of.material for of in evaluated.material_slots] or [None]
    return materials[min(slot, len(materials) - 1)]


def _merged(steps: list[Any]) -> dict[str, Any]:
    """The arrays of a mesh of corners, which are places, normals and perhaps uvs: at one time, or at several."""
    width = steps[0].shape[1]
    if all(np.array_equal(step, steps[0]) for step in steps):
        steps = steps[:1]
    # Corners that are alike in all, at all times, are one vertex.
    rows, indices = np.unique(np.concatenate(steps, axis=1), axis=0, return_inverse=True)
    columns = [rows[:, k * width : (k + 1) * width] for k in range(len(steps))]
    return {
        "vertices": columns[0][:, :3],
        "normals": columns[0][:, 3:6],
        "uvs": columns[0][:, 6:8] if width > 6 else None,
        "triangles": indices.reshape(-1, 3),
        "later": [(later[:, :3], later[:, 3:6]) for later in columns[1:]],
    }


class Exporter:
    """One export. `warnings` has what was left out, a sentence each."""

    def __init__(self, depsgraph: Any, set_frame: SetFrame | None = None) -> None:
        """Motion blur needs `set_frame`, which evaluates the graph at other times."""
        self._depsgraph = depsgraph
        self._set_frame = set_frame
        self._shutter: Shutter | None = None
        self._motions: Motions | None = None
        self._blender = depsgraph.scene_eval
        self.scene = Scene(depsgraph.scene.name)
        self.warnings: list[str] = []
        self._materials = Materials(self.scene, self.warnings)
        self._meshes: dict[Any, list[tuple[Any, dict[str, Any]]]] = {}  # by data, the parts of each

    def export(self) -> Scene:
        self._follow_motion()
        self.scene.units(metres=self._blender.unit_settings.scale_length or 1.0)
        self._film()
        self._camera()
        self._world()
        for key, place, thing in sorted(self._things(), key=_key_of):
            placings = (self._motions.of(key) if self._motions else []) or [(0.0, place)]
            if isinstance(thing, list):
                self._surface(thing, placings)
            else:
                self._lamp(thing, placings)
        return self.scene

    def _follow_motion(self) -> None:
        if self._set_frame is None or not self._blender.render.use_motion_blur:
            return
        self._shutter = Shutter(self._blender)
        now = self._blender.frame_current, self._blender.frame_subframe
        self._motions = Motions(self._shutter, self._set_frame, now, self._places, self._corners_of_deforming)
        self._blender = self._depsgraph.scene_eval

    def _places(self) -> Iterator[tuple[Any, Any, Any]]:
        """Keys of the camera, None, of surfaces and of lamps, with what each is and where."""
        camera = self._depsgraph.scene_eval.camera
        if camera is not None:
            yield None, camera, camera.matrix_world.copy()
        for instance in self._depsgraph.object_instances:
            if instance.show_self and instance.object.type in _SURFACES | {"LIGHT"}:
                yield _instance_key(instance), instance.object, instance.matrix_world.copy()

    def _things(self) -> Iterator[tuple[tuple[str, tuple[int, ...]], Any, Any]]:
        """A key, world from object, and the parts of each surface, or each lamp. The graph has them in an
        order that is another in each run."""
        for instance in self._depsgraph.object_instances:
            thing = instance.object
            if not instance.show_self:
                continue
            self._name_losses(thing)
            key = _instance_key(instance)
            if thing.type in _SURFACES:
                parts = self._deforming_parts(key, thing) or self._parts(thing)
                yield key, _array(instance.matrix_world), [(thing.name, *part) for part in parts]
            elif thing.type == "LIGHT":
                yield key, _array(instance.matrix_world), thing
            elif thing.type in {"VOLUME", "CURVES", "POINTCLOUD"}:
                self._materials.warn(f"object {thing.name}: {thing.type.lower()} is left out")

    def _name_losses(self, thing: Any) -> None:
        """Names what of the object has no counterpart, once for each."""
        for system in getattr(thing, "particle_systems", ()):
            shown = system.settings.render_type
            if shown not in {"OBJECT", "COLLECTION", "NONE"}:
                what = "hair" if system.settings.type == "HAIR" else f"particles as {shown.lower()}"
                self._materials.warn(f"object {thing.name}: {what} of '{system.name}' is left out")
        if not self._blender.render.use_motion_blur:
            return
        if self._motions is None and _moves(thing):
            self._materials.warn(f"object {thing.name}: motion blur is left out")

    # ---- camera and film

    @property
    def resolution(self) -> tuple[int, int]:
        render = self._blender.render
        scale = render.resolution_percentage / 100
        return max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale))

    @property
    def crop(self) -> tuple[int, int, int, int] | None:
        """The border, x0, y0, x1, y1 in pixels from the upper left."""
        render, (width, height) = self._blender.render, self.resolution
        if not render.use_border:
            return None
        # Blender cuts the numbers off, and counts rows upwards.
        x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
        low, high = int(render.border_min_y * height), int(render.border_max_y * height)
        return x0, height - max(high, low + 1), max(x1, x0 + 1), height - low

    def _film(self) -> None:
        # Cycles multiplies the render by it. The exposure of Blender's views is for screens alone.
        exposure = float(getattr(getattr(self._blender, "cycles", None), "film_exposure", 1.0))
        self.scene.film(*self.resolution, exposure=None if exposure == 1.0 else exposure)

    def _camera(self) -> None:
        camera = self._blender.camera
        if camera is None:
            raise ValueError("the scene has no camera")
        self._name_losses(camera)
        placings = (self._motions.of(None) if self._motions else []) or [(0.0, _array(camera.matrix_world))]
        # Blender's cameras look along -z.
        turned = np.diag([1.0, 1.0, -1.0, 1.0])
        keys = [(time, _unscaled(matrix) @ turned) for time, matrix in placings]
        CameraExport(self.scene, self._depsgraph, camera, keys[0][1], self._materials.warn).write()
        for message in (self.scene.message.camera, *self.scene.message.views):
            write_keys(keys, message)
            if self._shutter is not None:
                self._shutter.write(message)

    # ---- light

    def _world(self) -> None:
        world = self._blender.world
        if world is None:
            return
        tree = world.node_tree if world.use_nodes else None
        output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL") if tree else None
        if output is None:
            self._uniform_world(world.color[:3])
            return
        if output.inputs["Volume"].is_linked:
            self._materials.warn(f"world {world.name}: its volume is left out")
        links = output.inputs["Surface"].links
        if not links or links[0].from_node.type != "BACKGROUND":
            if links:
                node = links[0].from_node
                self._materials.warn(f"world {world.name}: '{node.name}' ({node.bl_label}) is not known")
            return
        background = links[0].from_node
        strength = float(background.inputs["Strength"].default_value)
        color = background.inputs["Color"]
        source = color.links[0].from_node if color.is_linked else None
        if source is not None and source.type == "TEX_ENVIRONMENT" and source.image is not None:
            self._environment(world, source, strength)
            return
        if source is not None:
            self._materials.warn(
                f"world {world.name}: '{source.name}' ({source.bl_label}) is not known; the colour is uniform"
            )
        self._uniform_world([strength * c for c in color.default_value[:3]])

    def _uniform_world(self, radiance: Any) -> None:
        if any(radiance):
            self.scene.environment(list(radiance))

    def _environment(self, world: Any, node: Any, strength: float) -> None:
        if node.projection != "EQUIRECTANGULAR":
            self._materials.warn(f"world {world.name}: mirror balls are taken for latitude and longitude")
        # The middle of the picture is at Blender's +x, a quarter at +y, and z is up.
        world_from_light = np.array(
            [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=np.float64
        )
        if node.inputs["Vector"].is_linked:
            mapping = node.inputs["Vector"].links[0].from_node
            if mapping.type == "MAPPING":
                # The mapping turns directions into the picture.
                turn = _array(mapping.inputs["Rotation"].default_value.to_matrix().to_4x4())
                world_from_light = np.linalg.inv(turn) @ world_from_light
            elif mapping.type != "TEX_COORD":
                self._materials.warn(f"world {world.name}: '{mapping.name}' ({mapping.bl_label}) is left out")
        path = Path(bpy.path.abspath(node.image.filepath_from_user())) if node.image.filepath else None
        picture: Any = path
        if path is None or node.image.packed_file or not path.is_file():
            is_srgb = node.image.colorspace_settings.name == "sRGB"
            picture = self._materials._pixels(node.image, is_srgb)
        self.scene.environment(picture, strength, world_from_light)

    def _lamp(self, lamp: Any, placings: list[tuple[float, Any]]) -> None:
        data = lamp.data
        place = _unscaled(placings[0][1])
        position, direction = place[:3, 3], -place[:3, 2]
        power = np.array(data.color[:]) * data.energy
        if not power.any():
            return
        if data.use_nodes and self._photometric_lamp(lamp, data, placings, power):
            return
        if data.use_nodes:
            self._materials.warn(f"lamp {lamp.name}: its nodes are left out")
        if data.type == "SUN":
            if data.angle > math.radians(1):
                self._materials.warn(f"lamp {lamp.name}: the sun's disk is a point")
            self.scene.distant_light(direction, power)
        elif data.type == "POINT":
            self.scene.point_light(position, power / (4 * math.pi), data.shadow_soft_size)
        elif data.type == "SPOT":
            cosine = math.cos(data.spot_size / 2)
            inner = math.acos(min(1.0, cosine + (1 - cosine) * data.spot_blend))
            self.scene.spot_light(
                position,
                position + direction,
                power / (4 * math.pi),
                math.degrees(data.spot_size / 2),
                math.degrees(data.spot_size / 2 - inner),
                data.shadow_soft_size,
            )
        else:
            self._area(lamp, data, placings, power)
            return
        if len(placings) > 1:
            self._move_lamp(lamp, placings)

    def _photometric_lamp(self, lamp: Any, data: Any, placings: list[tuple[float, Any]], power: Any) -> bool:
        """A lamp whose nodes have one IES texture shines as that file says, as bright as Cycles has it: its
        candela are lumens a steradian of white light of 177.83 lm/W, times the lamp's watts and the texture's
        strength. Whether it is one."""
        nodes = [node for node in data.node_tree.nodes if node.type == "TEX_IES"]
        if data.type not in {"POINT", "SPOT"} or len(nodes) != 1:
            return False
        node = nodes[0]
        if node.mode == "INTERNAL":
            if node.ies is None:
                return False
            file = node.ies.as_string().encode()
        else:
            path = Path(bpy.path.abspath(node.filepath))
            if not path.is_file():
                self._materials.warn(f"lamp {lamp.name}: {node.filepath} is not there; its nodes are left out")
                return False
            file = path.read_bytes()
        strength = 1.0 if node.inputs["Strength"].is_linked else float(node.inputs["Strength"].default_value)
        # Cycles' horizontal angles begin at -y and grow towards -x.
        turn = np.array([[0, -1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], dtype=np.float64)
        color = power / max(power)
        luminance = float(np.dot(color, (0.2126, 0.7152, 0.0722)))
        # Cycles knows no unit of length.
        cycles = 683 / 177.83 * self.scene.message.units.metres**2
        scale = float(max(power)) * luminance * strength * cycles
        place, last = (_unscaled(placings[i][1]) @ turn for i in (0, -1))
        self.scene.photometric_light(file, place, color, scale)
        if len(placings) > 1:
            end = self.scene.message.lights[-1].goniometric.world_from_light_end
            end.elements.extend(float(x) for x in last.flat)
        return True

    def _move_lamp(self, lamp: Any, placings: list[tuple[float, Any]]) -> None:
        """Has the last light go through the placings; a point has no directions."""
        rigid = [(time, _unscaled(matrix)) for time, matrix in placings]
        if lamp.data.type == "POINT":
            for _, matrix in rigid:
                matrix[:3, :3] = np.eye(3)
        back = np.linalg.inv(rigid[0][1])
        keys = [(time, matrix @ back) for time, matrix in rigid]
        if not all(np.allclose(matrix, keys[0][1], atol=1e-9) for _, matrix in keys):
            write_keys(keys, self.scene.message.lights[-1])

    def _area(self, lamp: Any, data: Any, placings: list[tuple[float, Any]], power: Any) -> None:
        """Radiance: power / (4 area), as Cycles has it; it shines along -z."""
        width, height = data.size, data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size
        corners: Any = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
        area = 1.0
        if data.shape in {"DISK", "ELLIPSE"}:
            angles = -np.linspace(0, 2 * math.pi, 64, endpoint=False)
            # The same area as the ellipse that it stands for.
            grow = math.sqrt(math.pi / (32 * math.sin(math.pi / 32)))
            corners = grow * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
            area = math.pi / 4
        place = _array(placings[0][1])
        points = [place @ np.array([x * width / 2, y * height / 2, 0, 1]) for x, y in corners]
        axes = np.linalg.norm(place[:3, :3], axis=0)
        area *= width * axes[0] * height * axes[1]
        radiance = power / (4 * area)
        shape = self.scene.rectangle([point[:3] for point in points], self._black(), radiance, name=lamp.name)
        if len(placings) > 1:
            write_keys([(time, matrix @ np.linalg.inv(place)) for time, matrix in placings], shape)

    def _black(self) -> Any:
        if not any(other.name == "lamp" for other in self.scene.message.materials):
            self.scene.diffuse("lamp", 0.0)
        return "lamp"

    # ---- surfaces

    def _surface(
        self, parts: list[tuple[str, Any, dict[str, Any]]], placings: list[tuple[float, Any]]
    ) -> None:
        for name, material, arrays in parts:
            surface = self._materials.surface(material)
            if not surface.is_seen:
                self._materials.warn(f"object {name}: it is a volume alone, and is left out")
                continue
            shape = self.scene.mesh(
                material=surface.material,
                emission=surface.emission,
                two_sided=True,
                transform=placings[0][1],
                name=name,
                **arrays,
            )
            write_keys(placings, shape)

    def _parts(self, evaluated: Any) -> list[tuple[Any, dict[str, Any]]]:
        """The object's triangles by material. Objects that share evaluated data share the arrays."""
        slots = tuple(slot.material.name if slot.material else "" for slot in evaluated.material_slots)
        shared = "" if evaluated.data and not evaluated.modifiers else evaluated.name
        key = (evaluated.data.as_pointer() if evaluated.data else 0, slots, shared)
        if key in self._meshes:
            return self._meshes[key]
        parts = [(_material(evaluated, slot), _merged([corners])) for slot, corners in self._corners(evaluated)]
        self._meshes[key] = parts
        return parts

    def _corners_of_deforming(self, thing: Any) -> list[tuple[int, Any]] | None:
        blurred = getattr(getattr(thing, "cycles", None), "use_deform_motion", True)
        is_surface = thing.type in _SURFACES
        return self._corners(thing) if is_surface and blurred and _changes_shape(thing) else None

    def _deforming_parts(self, key: Any, thing: Any) -> list[tuple[Any, dict[str, Any]]]:
        """The parts of what deforms, from where the shutter opens on; none of others."""
        steps = self._motions.shapes_of(key) if self._motions else []
        if not steps:
            return []
        first = steps[0]
        for step in steps[1:]:
            alike = len(step) == len(first) and all(a[1].shape == b[1].shape for a, b in zip(step, first))
            if not alike:
                self._materials.warn(
                    f"object {thing.name}: its faces change, and motion blur of its shape is left out"
                )
                return []
        return [
            (_material(thing, slot), _merged([step[part][1] for step in steps]))
            for part, (slot, _) in enumerate(first)
        ]

    def _corners(self, evaluated: Any) -> list[tuple[int, Any]]:
        """The corners of the object's triangles by material slot."""
        mesh = evaluated.to_mesh()
        parts: list[tuple[int, Any]] = []
        if mesh is not None and len(mesh.polygons):
            parts = self._split(mesh)
        evaluated.to_mesh_clear()
        return parts

    def _split(self, mesh: Any) -> list[tuple[int, Any]]:
        mesh.calc_loop_triangles()
        triangle_count, loop_count = len(mesh.loop_triangles), len(mesh.loops)
        positions = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", positions)
        vertex_of = np.empty(loop_count, np.int32)
        mesh.loops.foreach_get("vertex_index", vertex_of)
        normals = np.empty(3 * loop_count, np.float32)
        if hasattr(mesh, "calc_normals_split"):  # before Blender 4.1
            mesh.calc_normals_split()
            mesh.loops.foreach_get("normal", normals)
        else:
            mesh.corner_normals.foreach_get("vector", normals)
        loops = np.empty(3 * triangle_count, np.int32)
        mesh.loop_triangles.foreach_get("loops", loops)
        slots = np.empty(triangle_count, np.int32)
        mesh.loop_triangles.foreach_get("material_index", slots)
        columns = [positions.reshape(-1, 3)[vertex_of], normals.reshape(-1, 3)]
        if mesh.uv_layers.active is not None:
            uvs = np.empty(2 * loop_count, np.float32)
            mesh.uv_layers.active.data.foreach_get("uv", uvs)
            columns.append(uvs.reshape(-1, 2))
        corners = np.concatenate(columns, axis=1)
        triangles = loops.reshape(-1, 3)
        return [(int(slot), corners[triangles[slots == slot].ravel()]) for slot in np.unique(slots)]
