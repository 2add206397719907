"""Run by Blender: a scene with most of what the add-on translates, rendered by the engine that is named.

blender -b --factory-startup --python-exit-code 3 -P blender_scene.py -- ENGINE IMAGE.exr [LAMPS]
"""

from __future__ import annotations

import os
import sys

import bpy
import numpy as np

for folder in os.environ["PYTHONPATH"].split(":"):
    sys.path.insert(0, folder)

import tessera_blender  # noqa: E402
from tessera_blender.materials import input_of  # noqa: E402

engine, image, lamps = (sys.argv[sys.argv.index("--") + 1 :] + ["all"])[:3]


def principled(name: str, **inputs: object) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    for key, value in inputs.items():
        node = material.node_tree.nodes["Principled BSDF"]
        input_of(node, key.replace("_", " ")).default_value = value
    return material


def lamp(kind: str, place: tuple[float, ...], energy: float, turn: tuple[float, ...], **data: object) -> None:
    made = bpy.data.lights.new(kind, kind)
    made.energy = energy
    for key, value in data.items():
        setattr(made, key, value)
    holder = bpy.data.objects.new(kind, made)
    holder.location, holder.rotation_euler = place, turn
    bpy.context.scene.collection.objects.link(holder)


def build() -> None:
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    # Rough enough that no caustics are there, which Cycles blurs.
    floor = principled("floor", Roughness=1.0, Specular=0.0)
    quarters = np.zeros((64, 64, 4), np.float32)
    quarters[:32, :32] = 0.8, 0.2, 0.1, 1
    quarters[:32, 32:] = 0.1, 0.7, 0.2, 1
    quarters[32:, :32] = 0.2, 0.2, 0.8, 1
    quarters[32:, 32:] = 0.9, 0.9, 0.9, 1
    picture = bpy.data.images.new("quarters", 64, 64)
    picture.pixels.foreach_set(quarters.ravel())
    node = floor.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = picture
    socket = floor.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    floor.node_tree.links.new(node.outputs["Color"], socket)
    bpy.ops.mesh.primitive_plane_add(size=8)
    bpy.context.object.data.materials.append(floor)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=(-1, 0, 0.8))
    bpy.ops.object.shade_smooth()
    red = principled("red", Base_Color=(0.7, 0.1, 0.1, 1), Roughness=0.6)
    bpy.context.object.data.materials.append(red)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(1.2, 0.3, 0.5), rotation=(0, 0, 0.5))
    cube = bpy.context.object
    cube.data.materials.append(principled("blue", Base_Color=(0.1, 0.2, 0.7, 1), Roughness=0.8))
    twin = cube.copy()  # of the same mesh
    twin.location = (1.2, 1.6, 0.5)
    scene.collection.objects.link(twin)
    if lamps in ("area", "all"):
        lamp("AREA", (1, -1, 4), 100, (0, 0, 0), shape="RECTANGLE", size=1.0, size_y=2.0)
    if lamps in ("disk", "all"):
        lamp("AREA", (-2, 2, 4), 100, (0.3, 0, 0), shape="DISK", size=1.0)
    if lamps in ("point", "all"):
        lamp("POINT", (-2, -2, 3), 100, (0, 0, 0), shadow_soft_size=0.2, color=(1, 0.5, 0.3))
    if lamps in ("spot", "all"):
        lamp("SPOT", (2.5, -2.5, 4), 300, (0.7, 0, 0.785), shadow_soft_size=0.15, spot_size=0.8, spot_blend=0.5)
    if lamps in ("sun", "all"):
        lamp("SUN", (0, 0, 5), 0.5, (0.5, 0.3, 0), angle=0.0)
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    scene.world = world
    background = world.node_tree.nodes["Background"]
    background.inputs["Strength"].default_value = 0.3 if lamps in ("sky", "all") else 0.0
    background.inputs["Color"].default_value = (0.2, 0.3, 0.5, 1)
    if lamps == "picture":
        background.inputs["Strength"].default_value = 1.0
        sky = np.ones((32, 64, 4), np.float32)
        sky[..., :3] = 0.1
        sky[16:, :16, 0], sky[16:, 16:32, 1], sky[16:, 32:40, 2] = 3, 2, 4
        picture = bpy.data.images.new("sky", 64, 32, float_buffer=True)
        picture.pixels.foreach_set(sky.ravel())
        nodes, links = world.node_tree.nodes, world.node_tree.links
        texture, mapping = nodes.new("ShaderNodeTexEnvironment"), nodes.new("ShaderNodeMapping")
        texture.image = picture
        mapping.inputs["Rotation"].default_value = (0.2, 0, 0.6)
        links.new(nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
        links.new(texture.outputs["Color"], background.inputs["Color"])
    camera = bpy.data.cameras.new("camera")
    camera.lens, camera.shift_x, camera.shift_y = 40, 0.05, -0.02
    camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 7, 0.5
    holder = bpy.data.objects.new("camera", camera)
    holder.location, holder.rotation_euler = (0, -7, 3.5), (1.15, 0, 0.05)
    scene.collection.objects.link(holder)
    scene.camera = holder
    if lamps == "bokeh":
        # A bright point far beyond the focus, which the picture shows as the aperture.
        for thing in list(bpy.data.objects):
            if thing is not holder:
                bpy.data.objects.remove(thing)
        holder.location, holder.rotation_euler = (0, 0, 0), (1.5708, 0, 0)
        camera.shift_x = camera.shift_y = 0
        camera.dof.focus_distance, camera.dof.aperture_fstop = 1, 0.08
        camera.dof.aperture_blades, camera.dof.aperture_rotation, camera.dof.aperture_ratio = 3, 0.3, 1.5
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.4, location=(0, 20, 0))
        glow = principled("glow", Base_Color=(0, 0, 0, 1), Specular=0.0, Emission=(1, 1, 1, 1), Emission_Strength=500.0)
        bpy.context.object.data.materials.append(glow)


    if lamps in ("motion", "rolling", "stands"):
        animate(holder)


def animate(camera: bpy.types.Object) -> None:
    """A block that glows, turns and slides, before a camera that pans."""
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        if thing is not camera:
            bpy.data.objects.remove(thing)
    camera.location, camera.rotation_euler = (0, -7, 0), (1.5708, 0, 0)
    camera.data.dof.use_dof = False
    bpy.ops.mesh.primitive_cube_add(size=1, location=(-0.5, 0, 0.3))
    block = bpy.context.object
    block.scale = (3, 0.5, 0.5)
    white = principled("white", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1.0, Specular=0.0)
    block.data.materials.append(white)
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Strength"].default_value, background.inputs["Color"].default_value = 1.0, (1, 0.2, 0.2, 1)
    lamp("SUN", (0, 0, 5), 3.0, (0.9, 0.2, 0), angle=0.0)
    # Frame 1 is in the middle of a shutter of half a frame.
    for frame, x, turn, pan in ((0, -1.5, -4.4, 0.1), (2, 0.5, 4.4, -0.1)):
        block.location.x, block.rotation_euler.y, camera.rotation_euler.z = x, turn, pan
        for thing in (block, camera):
            thing.keyframe_insert("location", frame=frame)
            thing.keyframe_insert("rotation_euler", frame=frame)
            for curve in thing.animation_data.action.fcurves:
                for key in curve.keyframe_points:
                    key.interpolation = "LINEAR"
    scene.frame_set(1)
    scene.render.use_motion_blur = lamps != "stands"
    scene.render.motion_blur_shutter = 0.5
    block.cycles.motion_steps = 4
    if lamps == "motion":
        points = scene.render.motion_blur_shutter_curve.curves[0].points
        while len(points) > 2:
            points.remove(points[1])
        points[0].location, points[-1].location = (0, 0), (1, 1)
    if lamps == "rolling":
        scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = "TOP", 0.1


tessera_blender.register()
build()
scene = bpy.context.scene
render = scene.render
render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 64, 100
render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
render.image_settings.exr_codec = "ZIP"
render.filepath = image
scene.view_settings.view_transform = "Standard"
if engine == "cycles":
    render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 128
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type, scene.cycles.blur_glossy = "BOX", 0
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 12
    scene.cycles.sample_clamp_indirect = 0
else:
    render.engine = "TESSERA"
    scene.tessera.samples = 128
    scene.tessera.comment = "from Blender"
    if engine == "border":
        render.use_border = True
        render.border_min_x, render.border_max_x = 0.25, 0.75
        render.border_min_y, render.border_max_y = 0.125, 0.5
if engine == "submit":
    assert bpy.ops.tessera.submit() == {"FINISHED"}
    print("submitted", scene.tessera.last_job)
else:
    bpy.ops.render.render(write_still=True)
