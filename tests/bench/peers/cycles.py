"""Cycles as a peer of `tessera bench`: renders a small subset of pbrt-v4 in Blender (Debian: package `blender`).

    tessera bench scenes/cornell-box/scene.pbrt --resolution 160x120 --make-reference 1024 \\
      --peer "blender -b --factory-startup --python-exit-code 1 -P tests/bench/peers/cycles.py -- \\
              {scene} {spp} {seed} {threads} {out} 160x120"

Perspective cameras, triangle meshes, diffuse materials and diffuse area lights, which emit from the side of their
normals. Anything else is refused by name: a scene that is rendered otherwise would measure nothing. Noise is not
removed, light is not clamped, all pixels take {spp} samples, and the filter is a box of one pixel, so Cycles is held
against a reference of its own.
"""
import re
import sys

import bpy
from mathutils import Matrix, Vector

KEEPS = {"CoordinateSystem", "Sampler", "PixelFilter", "WorldBegin", "AttributeBegin", "AttributeEnd", "ColorSpace"}


def tokens(text):
    text = re.sub(r"#[^\n]*", "", text)
    return re.findall(r'"[^"]*"|[\[\]]|[^\s\[\]"]+', text)


class Scene:
    """The contents of a file: the camera, and meshes with the material and light that hold for them."""

    def __init__(self, path):
        with open(path) as file:
            self.words = tokens(file.read())
        self.at = 0
        self.camera_from_world = Matrix.Identity(4)
        self.fov = None
        self.film = {}
        self.depth = 5
        self.materials = {}
        self.meshes = []
        self.state = {"material": (0.5, 0.5, 0.5), "light": None, "matrix": Matrix.Identity(4)}
        self.stack = []
        self.read()

    def values(self):
        """Text, a number, or the list of either."""
        word = self.words[self.at]
        self.at += 1
        if word != "[":
            return [word.strip('"')]
        end = self.words.index("]", self.at)
        result = [v.strip('"') for v in self.words[self.at:end]]
        self.at = end + 1
        return result

    def parameters(self):
        result = {}
        while self.at < len(self.words) and re.match(r'"\w+ +\w+"$', self.words[self.at]):
            kind, name = self.words[self.at].strip('"').split()
            self.at += 1
            values = self.values()
            numeric = kind not in ("string", "bool", "texture", "spectrum")
            result[name] = [float(v) for v in values] if numeric else values
        return result

    def kind(self, directive, *known):
        found = self.values()[0]
        if found not in known:
            sys.exit(f'{directive} "{found}" is not known here')
        return found

    def numbers(self, count):
        if self.words[self.at] == "[":
            return [float(v) for v in self.values()]
        self.at += count
        return [float(v) for v in self.words[self.at - count:self.at]]

    def matrix(self):
        m = self.numbers(16)
        return Matrix([m[0::4], m[1::4], m[2::4], m[3::4]])

    def read(self):
        in_world = False
        while self.at < len(self.words):
            word = self.words[self.at]
            self.at += 1
            if word in ("Transform", "ConcatTransform"):
                matrix = self.matrix()
                if word == "ConcatTransform":
                    matrix = self.state["matrix"] @ matrix
                self.state["matrix"] = matrix
            elif word == "LookAt":
                n = self.numbers(9)
                eye, to, up = Vector(n[0:3]), Vector(n[3:6]), Vector(n[6:9])
                z = (to - eye).normalized()
                x = up.normalized().cross(z).normalized()
                y = z.cross(x)
                world = Matrix([[x[i], y[i], z[i], eye[i]] for i in range(3)] + [[0, 0, 0, 1]])
                self.state["matrix"] = self.state["matrix"] @ world.inverted()
            elif word == "Camera":
                self.kind(word, "perspective")
                self.camera_from_world = self.state["matrix"].copy()
                self.fov = self.parameters().get("fov", [90])[0]
            elif word == "Film":
                self.values()
                self.film = self.parameters()
            elif word == "Integrator":
                self.values()
                self.depth = int(self.parameters().get("maxdepth", [5])[0])
            elif word == "MakeNamedMaterial":
                name = self.values()[0]
                parameters = self.parameters()
                self.materials[name] = self.diffuse(parameters.pop("type")[0], parameters)
            elif word == "Material":
                self.state["material"] = self.diffuse(self.values()[0], self.parameters())
            elif word == "NamedMaterial":
                self.state["material"] = self.materials[self.values()[0]]
            elif word == "AreaLightSource":
                self.kind(word, "diffuse")
                light = self.parameters()
                unknown = set(light) - {"L", "scale"}
                if unknown:
                    sys.exit(f"an area light with {unknown} is not known here")
                self.state["light"] = [v * light.get("scale", [1])[0] for v in light["L"]]
            elif word == "Shape":
                self.kind(word, "trianglemesh")
                shape = self.parameters()
                p = [self.state["matrix"] @ Vector(shape["P"][i:i + 3]) for i in range(0, len(shape["P"]), 3)]
                i = [int(v) for v in shape.get("indices", [0, 1, 2])]
                triangles = [i[k:k + 3] for k in range(0, len(i), 3)]
                if self.state["matrix"].determinant() < 0:
                    triangles = [t[::-1] for t in triangles]
                self.meshes.append((p, triangles, self.state["material"], self.state["light"]))
            elif word in KEEPS:
                if word == "AttributeBegin":
                    self.stack.append({**self.state, "matrix": self.state["matrix"].copy()})
                elif word == "AttributeEnd":
                    self.state = self.stack.pop()
                elif word == "WorldBegin":
                    in_world = True
                    self.state["matrix"] = Matrix.Identity(4)
                else:
                    self.values()
                    self.parameters()
            else:
                sys.exit(f"{word} is not known here")
        if not in_world or self.fov is None:
            sys.exit("the file has no camera, or no world")

    def diffuse(self, kind, parameters):
        unknown = set(parameters) - {"reflectance"}
        if kind != "diffuse" or unknown:
            sys.exit(f'a material "{kind}" with {unknown} is not known here')
        return tuple(parameters.get("reflectance", [0.5, 0.5, 0.5]))


def make_material(color, light):
    material = bpy.data.materials.new("m")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    surface = nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = (*color, 1)
    if light is None:
        links.new(surface.outputs["BSDF"], output.inputs["Surface"])
        return material
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*light, 1)
    emission.inputs["Strength"].default_value = 1
    both = nodes.new("ShaderNodeAddShader")
    links.new(surface.outputs["BSDF"], both.inputs[0])
    links.new(emission.outputs["Emission"], both.inputs[1])
    sides = nodes.new("ShaderNodeMixShader")
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], sides.inputs[0])
    links.new(both.outputs["Shader"], sides.inputs[1])
    links.new(surface.outputs["BSDF"], sides.inputs[2])
    links.new(sides.outputs["Shader"], output.inputs["Surface"])
    return material


def main(path, spp, seed, threads, out, size=None):
    said = Scene(path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for points, triangles, color, light in said.meshes:
        mesh = bpy.data.meshes.new("mesh")
        mesh.from_pydata(points, [], triangles)
        mesh.materials.append(make_material(color, light))
        scene.collection.objects.link(bpy.data.objects.new("mesh", mesh))

    film = [int(said.film.get(name, [default])[0])
            for name, default in (("xresolution", 1280), ("yresolution", 720))]
    width, height = [int(v) for v in size.split("x")] if size else film
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit = "HORIZONTAL" if width <= height else "VERTICAL"
    camera.angle = said.fov * 3.14159265358979 / 180
    camera.clip_start, camera.clip_end = 1e-4, 1e6
    viewer = bpy.data.objects.new("camera", camera)
    # Blender's cameras look along -z.
    world_from_camera = (Matrix.Diagonal((1, 1, -1, 1)) @ said.camera_from_world).inverted()
    if world_from_camera.determinant() < 0:
        sys.exit("a mirrored camera is not known here")
    viewer.matrix_world = world_from_camera
    scene.collection.objects.link(viewer)
    scene.camera = viewer

    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    cycles.device = "CPU"
    cycles.samples, cycles.seed = int(spp), int(seed)
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.max_bounces = cycles.diffuse_bounces = said.depth
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    render.threads_mode, render.threads = "FIXED", int(threads)
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    render.use_file_extension = False
    render.filepath = out
    bpy.ops.render.render(write_still=True)


main(*sys.argv[sys.argv.index("--") + 1:])
