"""Run by Blender: a picture by each kind of camera, by the engine that is named.

blender -b --factory-startup --python-exit-code 3 -P blender_cameras.py -- ENGINE FOLDER

All that is seen is a sky whose colour tells the direction, and balls that tell the place.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from math import radians
from typing import Any

import bpy
import numpy as np

for folder in os.environ["PYTHONPATH"].split(":"):
    sys.path.insert(0, folder)

import tessera_blender  # noqa: E402

engine, pictures = sys.argv[sys.argv.index("--") + 1 :]


def build() -> Any:
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene = bpy.context.scene
    turn, height = np.meshgrid(2 * np.pi * (np.arange(512) + 0.5) / 512, (np.arange(256) + 0.5) / 256)
    sky = np.ones((256, 512, 4), np.float32)
    sky[..., 0], sky[..., 1], sky[..., 2] = 0.5 + 0.4 * np.cos(turn), 0.5 + 0.4 * np.sin(turn), height
    picture = bpy.data.images.new("sky", 512, 256, float_buffer=True)
    picture.pixels.foreach_set(sky.ravel())
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = picture
    links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])
    glow = bpy.data.materials.new("glow")
    glow.use_nodes = True
    inputs = glow.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Specular"].default_value = (0, 0, 0, 1), 0
    inputs["Emission"].default_value, inputs["Emission Strength"].default_value = (1, 1, 1, 1), 3
    for x, y, z in ((0, 1.5, 0.3), (1, 2, -0.4), (-1, 3, 0), (-1.5, -0.5, 0.4), (0.3, 0.3, 1.2)):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.25, location=(x, y, z))
        bpy.context.object.data.materials.append(glow)
    data = bpy.data.cameras.new("camera")
    holder = bpy.data.objects.new("camera", data)
    holder.rotation_euler = (radians(90), 0, radians(10))
    scene.collection.objects.link(holder)
    scene.camera = holder
    return data


def panorama(kind: str, **lens: float) -> Callable[[Any, Any], None]:
    def change(camera: Any, render: Any) -> None:
        camera.type, camera.cycles.panorama_type = "PANO", kind
        for name, value in lens.items():
            setattr(camera.cycles, name, value)

    return change


def cube_face(camera: Any, render: Any) -> None:
    panorama("EQUIANGULAR_CUBEMAP_FACE")(camera, render)
    render.resolution_x = render.resolution_y = 64


def equisolid(camera: Any, render: Any) -> None:
    panorama("FISHEYE_EQUISOLID", fisheye_lens=9, fisheye_fov=radians(200))(camera, render)
    camera.sensor_fit, camera.sensor_height = "VERTICAL", 22


def polynomial(camera: Any, render: Any) -> None:
    values = {"k0": 0, "k1": -0.06, "k2": 1e-4, "k3": -5e-5, "k4": 1e-7}
    lens = {f"fisheye_polynomial_{name}": value for name, value in values.items()}
    panorama("FISHEYE_LENS_POLYNOMIAL", fisheye_fov=radians(160), **lens)(camera, render)


def orthographic(camera: Any, render: Any) -> None:
    camera.type, camera.ortho_scale, camera.shift_x = "ORTHO", 4, 0.1
    camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 2, 1.5
    camera.dof.aperture_blades, camera.dof.aperture_ratio = 5, 1.4


def stereo(mode: str, pivot: str = "CENTER") -> Callable[[Any, Any], None]:
    def change(camera: Any, render: Any) -> None:
        render.use_multiview, render.views_format = True, "STEREO_3D"
        render.image_settings.views_format = "INDIVIDUAL"
        eyes = camera.stereo
        eyes.convergence_mode, eyes.pivot = mode, pivot
        eyes.interocular_distance, eyes.convergence_distance = 0.4, 2.5

    return change


def around(camera: Any, render: Any) -> None:
    stereo("OFFAXIS")(camera, render)
    panorama("EQUIRECTANGULAR")(camera, render)
    eyes = camera.stereo
    eyes.use_spherical_stereo = eyes.use_pole_merge = True
    eyes.pole_merge_angle_from, eyes.pole_merge_angle_to = radians(50), radians(75)


def around_lens(camera: Any, render: Any) -> None:
    panorama("EQUIRECTANGULAR")(camera, render)
    camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 3, 0.15


CAMERAS: dict[str, Callable[[Any, Any], None]] = {
    "equirectangular": panorama("EQUIRECTANGULAR"),
    "part": panorama(
        "EQUIRECTANGULAR",
        longitude_min=radians(-60),
        longitude_max=radians(140),
        latitude_min=radians(-40),
        latitude_max=radians(70),
    ),
    "cube_face": cube_face,
    "mirror_ball": panorama("MIRRORBALL"),
    "equidistant": panorama("FISHEYE_EQUIDISTANT", fisheye_fov=radians(210)),
    "equisolid": equisolid,
    "polynomial": polynomial,
    "orthographic": orthographic,
    "off_axis": stereo("OFFAXIS"),
    "parallel": stereo("PARALLEL", "LEFT"),
    "toe_in": stereo("TOE"),
    "around": around,
    "around_lens": around_lens,
}

tessera_blender.register()
data = build()
scene = bpy.context.scene
render = scene.render
render.resolution_percentage = 100
render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
render.image_settings.exr_codec = "ZIP"
scene.view_settings.view_transform = "Standard"
if engine == "cycles":
    render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 64
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
else:
    render.engine = "TESSERA"
    scene.tessera.samples = 64
holder = scene.camera
for name, change in CAMERAS.items():
    holder.data = data.copy()
    render.resolution_x, render.resolution_y, render.use_multiview = 96, 64, False
    change(holder.data, render)
    render.filepath = f"{pictures}/{name}.exr"
    bpy.ops.render.render(write_still=True)
