"""The render engine: a job of a farm, whose tiles show as they come."""

from __future__ import annotations

import time
from typing import Any

import bpy
import numpy as np
import tessera

from .export import Exporter
from .motion import SetFrame

_PATIENCE = 0.5  # seconds between updates of the picture


def farm_of(settings: Any) -> tessera.Farm:
    return tessera.Farm(
        settings.server or None,
        tls=bpy.path.abspath(settings.tls) if settings.tls else None,
        allow_insecure=settings.allow_insecure,
        program=settings.program or None,
    )


def submit(farm: tessera.Farm, depsgraph: Any, set_frame: SetFrame) -> tuple[tessera.Job, Exporter]:
    """Exports what the dependency graph has, and submits it as the scene's settings say."""
    settings = depsgraph.scene.tessera
    exporter = Exporter(depsgraph, set_frame)
    scene = exporter.export()
    scene.settings.integrator = settings.integrator
    scene.settings.spp = settings.samples
    scene.settings.noise = settings.noise
    scene.settings.max_depth = settings.max_depth
    scene.settings.seed = settings.seed
    job = farm.submit(
        scene,
        comment=settings.comment,
        priority=settings.priority,
        crop=exporter.crop,
    )
    return job, exporter


class TesseraRenderEngine(bpy.types.RenderEngine):
    bl_idname = "TESSERA"
    bl_label = "Tessera"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False

    def render(self, depsgraph: Any) -> None:
        """Called by Blender for the final picture, in a thread of its own."""
        try:
            with farm_of(depsgraph.scene.tessera) as farm:
                self.update_stats("", "Tessera: exporting and uploading")
                job, exporter = submit(farm, depsgraph, lambda frame, part: self.frame_set(frame, subframe=part))
                for warning in exporter.warnings:
                    self.report({"WARNING"}, warning)
                views = 1 + len(exporter.scene.message.views)
                for view in range(views):
                    self._show(job, exporter, view if views > 1 else None)
        except (tessera.TesseraError, ValueError, OSError) as error:
            self.report({"ERROR"}, f"Tessera: {error}")
            self.error_set(str(error))

    def _show(self, job: tessera.Job, exporter: Exporter, eye: int | None) -> None:
        """Shows the picture, or of a stereo pair that of an eye."""
        width, height = exporter.resolution
        x0, _, _, y1 = exporter.crop or (0, 0, width, height)
        origin = x0, height - y1  # results are counted from the border's corner
        fresh: dict[tessera.Rect, tessera.TileUpdate] = {}
        shown = time.monotonic()
        for update in job.updates(eye or 0):
            if self.test_break():
                job.cancel()
                return
            if isinstance(update, tessera.TileUpdate):
                fresh[update.pixels] = update
            if isinstance(update, tessera.Progress):
                self._tell(job, update)
                if time.monotonic() - shown > _PATIENCE or update.is_over:
                    self._put(list(fresh.values()), height, origin, eye)
                    fresh.clear()
                    shown = time.monotonic()
                if update.is_over and update.state != "done":
                    self.report({"ERROR"}, f"Tessera: job {job.id} is {update.state}: {update.error}")

    def _tell(self, job: tessera.Job, progress: tessera.Progress) -> None:
        self.update_progress(progress.fraction)
        waits = f", waits: {progress.waiting_for}" if progress.waiting_for else ""
        self.update_stats("", f"Tessera: job {job.id}, {progress.workers} workers{waits}")

    def _put(
        self, tiles: list[tessera.TileUpdate], height: int, origin: tuple[int, int], eye: int | None
    ) -> None:
        """Rows go upwards in Blender."""
        view: dict[str, str] = {} if eye is None else {"view": ("left", "right")[eye]}
        for tile in tiles:
            pixels = tile.pixels
            x, y = pixels.x0 - origin[0], height - pixels.y1 - origin[1]
            result = self.begin_result(x, y, pixels.width, pixels.height, **view)
            bands = [tile.channels[name] for name in "RGBA"]
            rgba = np.stack(bands, axis=-1)[::-1]
            if not bpy.context.scene.render.film_transparent:
                rgba = rgba.copy()
                rgba[..., 3] = 1
            result.layers[0].passes["Combined"].rect = rgba.reshape(-1, 4).tolist()
            self.end_result(result)
