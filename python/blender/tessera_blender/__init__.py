"""Tessera for Blender: a render engine on a farm, and jobs from the menu (docs/python.md)."""

from __future__ import annotations

from typing import Any

import bpy

bl_info = {
    "name": "Tessera",
    "author": "the maintainers of Tessera",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render Properties > Render Engine; Render menu",
    "description": "Renders on a Tessera farm",
    "category": "Render",
}

import tessera  # noqa: E402

from . import engine  # noqa: E402
from .export import Exporter  # noqa: E402
from .motion import SetFrame  # noqa: E402

_INTEGRATORS = [
    ("path", "Path", "paths from the camera, over surfaces"),
    ("volpath", "Volume path", "paths from the camera, through media too"),
    ("direct", "Direct", "lights and what they light, without light between surfaces"),
    ("bdpt", "Bidirectional", "paths from camera and lights, joined in all ways (through the program tessera)"),
    ("vcm", "VCM", "bdpt with merging: caustics in mirrors (through the program tessera)"),
]


def frame_setter(context: Any) -> SetFrame:
    return lambda frame, part: context.scene.frame_set(frame, subframe=part)


class TesseraSettings(bpy.types.PropertyGroup):
    server: bpy.props.StringProperty(  # type: ignore[valid-type]
        name="Server", description="HOST:PORT of the coordinator; empty: $TESSERA_SERVER, or 127.0.0.1:7070"
    )
    tls: bpy.props.StringProperty(  # type: ignore[valid-type]
        name="Certificates", description="folder of a client; empty: $TESSERA_TLS", subtype="DIR_PATH"
    )
    allow_insecure: bpy.props.BoolProperty(  # type: ignore[valid-type]
        name="Allow insecure", description="talk to another machine without encryption"
    )
    program: bpy.props.StringProperty(  # type: ignore[valid-type]
        name="Program", description="tessera, for integrators that need it; empty: on the PATH", subtype="FILE_PATH"
    )
    integrator: bpy.props.EnumProperty(name="Integrator", items=_INTEGRATORS)  # type: ignore[valid-type]
    samples: bpy.props.IntProperty(  # type: ignore[valid-type]
        name="Samples", description="a pixel; with a noise the upper bound", default=64, min=1, max=1 << 24
    )
    noise: bpy.props.FloatProperty(  # type: ignore[valid-type]
        name="Noise", description="relative error at which a pixel has enough; 0: none", min=0, max=1, precision=4
    )
    max_depth: bpy.props.IntProperty(  # type: ignore[valid-type]
        name="Max depth", description="scattering events on a path", default=12, min=0, max=32767
    )
    seed: bpy.props.IntProperty(name="Seed", min=0)  # type: ignore[valid-type]
    priority: bpy.props.IntProperty(name="Priority", description="higher goes first")  # type: ignore[valid-type]
    comment: bpy.props.StringProperty(name="Comment")  # type: ignore[valid-type]
    last_job: bpy.props.StringProperty(name="Last job")  # type: ignore[valid-type]


class TesseraSubmit(bpy.types.Operator):
    """Submits the current frame as a job of the farm, and leaves it to the farm"""

    bl_idname = "tessera.submit"
    bl_label = "Submit to Tessera"

    def execute(self, context: Any) -> set[str]:
        settings = context.scene.tessera
        try:
            with engine.farm_of(settings) as farm:
                job, exporter = engine.submit(farm, context.evaluated_depsgraph_get(), frame_setter(context))
        except (tessera.TesseraError, ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for warning in exporter.warnings:
            self.report({"WARNING"}, warning)
        settings.last_job = job.id
        self.report({"INFO"}, f"job {job.id}")
        return {"FINISHED"}


class TesseraExport(bpy.types.Operator):
    """Writes the current frame as a scene of Tessera"""

    bl_idname = "tessera.export"
    bl_label = "Export for Tessera"
    filepath: bpy.props.StringProperty(subtype="FILE_PATH")  # type: ignore[valid-type]

    def invoke(self, context: Any, event: Any) -> set[str]:
        self.filepath = "scene.textproto"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> set[str]:
        exporter = Exporter(context.evaluated_depsgraph_get(), frame_setter(context))
        try:
            exporter.export().save(bpy.path.abspath(self.filepath))
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for warning in exporter.warnings:
            self.report({"WARNING"}, warning)
        return {"FINISHED"}


class TesseraPanel(bpy.types.Panel):
    bl_label = "Tessera"
    bl_idname = "RENDER_PT_tessera"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"TESSERA"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.engine in cls.COMPAT_ENGINES)

    def draw(self, context: Any) -> None:
        self.layout.use_property_split = True
        for name in ("integrator", "samples", "noise", "max_depth", "seed"):
            self.layout.prop(context.scene.tessera, name)
        self.layout.separator()
        for name in ("server", "tls", "allow_insecure", "program", "priority", "comment"):
            self.layout.prop(context.scene.tessera, name)
        self.layout.operator(TesseraSubmit.bl_idname)
        if context.scene.tessera.last_job:
            self.layout.label(text=f"Last job: {context.scene.tessera.last_job}")


_CLASSES = (TesseraSettings, TesseraSubmit, TesseraExport, TesseraPanel, engine.TesseraRenderEngine)


def _shared_panels() -> list[Any]:
    """Blender's own panels that are for all engines."""
    return [
        panel
        for panel in bpy.types.Panel.__subclasses__()
        if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ())
    ]


def _menu(self: Any, context: Any) -> None:
    self.layout.separator()
    self.layout.operator(TesseraSubmit.bl_idname)


def _export_menu(self: Any, context: Any) -> None:
    self.layout.operator(TesseraExport.bl_idname, text="Tessera (.textproto)")


def register() -> None:
    for kind in _CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.tessera = bpy.props.PointerProperty(type=TesseraSettings)
    bpy.types.TOPBAR_MT_render.append(_menu)
    bpy.types.TOPBAR_MT_file_export.append(_export_menu)
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.add("TESSERA")


def unregister() -> None:
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.discard("TESSERA")
    bpy.types.TOPBAR_MT_file_export.remove(_export_menu)
    bpy.types.TOPBAR_MT_render.remove(_menu)
    del bpy.types.Scene.tessera
    for kind in reversed(_CLASSES):
        bpy.utils.unregister_class(kind)
