"""Run by Blender: exports a scene of much that Tessera lacks, and prints the warnings.

blender -b --factory-startup --python-exit-code 3 -P blender_losses.py -- SCENE.textproto
"""

from __future__ import annotations

import os
import sys

import bpy

for folder in os.environ["PYTHONPATH"].split(":"):
    sys.path.insert(0, folder)

import tessera_blender  # noqa: E402
from tessera_blender.export import Exporter  # noqa: E402

tessera_blender.register()
scene = bpy.context.scene
scene.render.use_motion_blur = True

# The cube of the start-up file moves, and so does what hangs on it.
cube = bpy.data.objects["Cube"]
for frame, x in ((1, 0), (5, 4)):
    cube.location.x = x
    cube.keyframe_insert("location", frame=frame)
bpy.ops.mesh.primitive_ico_sphere_add(location=(0, 3, 0))
ball = bpy.context.object
ball.name, ball.parent = "ball", cube

bpy.ops.mesh.primitive_plane_add(size=4)
lawn = bpy.context.object
lawn.name = "lawn"
lawn.modifiers.new("grass", "PARTICLE_SYSTEM")
lawn.particle_systems[0].settings.type = "HAIR"
lawn.particle_systems[0].settings.count = 5

bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 3))
cloud = bpy.context.object
cloud.name = "cloud"
fog = bpy.data.materials.new("fog")
fog.use_nodes = True
nodes, links = fog.node_tree.nodes, fog.node_tree.links
nodes.remove(nodes["Principled BSDF"])
links.new(nodes.new("ShaderNodeVolumePrincipled").outputs[0], nodes["Material Output"].inputs["Volume"])
cloud.data.materials.append(fog)

# A shape that changes.
ball.shape_key_add(name="Basis")
for point in ball.shape_key_add(name="large").data:
    point.co *= 2
for frame, value in ((1, 0), (5, 1)):
    ball.data.shape_keys.key_blocks["large"].value = value
    ball.data.shape_keys.key_blocks["large"].keyframe_insert("value", frame=frame)

# The lamp of the file goes along.
lamp = bpy.data.objects["Light"]
for frame, x in ((1, 0), (5, 4)):
    lamp.location.x = x
    lamp.keyframe_insert("location", frame=frame)

exporter = Exporter(bpy.context.evaluated_depsgraph_get(), tessera_blender.frame_setter(bpy.context))
exporter.export().save(sys.argv[-1])
for warning in exporter.warnings:
    print("warning:", warning)
