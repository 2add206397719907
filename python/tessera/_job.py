"""The spec of a job for a scene that was built in code.

Everything in a spec is resolved (proto/tessera/v1/job.proto), and the rules stand in the command line's C++
(client/command/jobs/job_settings.cpp). Here are those for integrators without settings and phases of their own; a
test compares the specs of both. Other integrators are submitted through the program.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Sequence

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from tessera._values import checked
from tessera.scene import Blob, Scene
from tessera.v1 import camera_pb2, job_pb2, setting_pb2, settings_pb2

#: Integrators whose jobs are made here.
DIRECT = ("path", "volpath", "direct")

_TILE, _BORDERED_TILE = 32, 128
_SAMPLES_PER_UNIT = 1 << 14
_SAMPLES_PER_PASSES = 1 << 18
_USUAL_UNITS = 1 << 20
_LEAST_BORDERED_SAMPLES = 4
_MAX_DEPTH = (1 << 15) - 1
_PILOT_PIXELS, _MOST_PILOT_PARTS = 1 << 15, 1024  # of the phase that --noise adds

AOVS = {
    name[4:].lower().replace("_", "-"): number
    for name, number in job_pb2.AOV.items()
    if number != job_pb2.AOV_UNSPECIFIED and not name.startswith("AOV_CRYPTO")
}


def _floor_power(n: int) -> int:
    return 1 << (max(n, 1).bit_length() - 1)


def _ceil_power(n: int) -> int:
    return 1 << (max(n, 1) - 1).bit_length()


def _gains_by_scattering(pixel_filter: camera_pb2.PixelFilter) -> bool:
    """proto/wire/pixel_filter.cpp"""
    kinds = camera_pb2.PixelFilter
    usual = {kinds.TRIANGLE: 2.0, kinds.MITCHELL: 2.0, kinds.GAUSSIAN: 1.5, kinds.LANCZOS: 4.0}
    if pixel_filter.kind not in usual:
        return False
    radii = [r if r > 0 else usual[pixel_filter.kind] for r in (pixel_filter.radius_x, pixel_filter.radius_y)]
    if pixel_filter.kind == kinds.GAUSSIAN and (pixel_filter.sigma or 0.5) < 0.34:
        return False
    return min(radii) >= 0.8 and max(radii) <= 16


def _is_set(message: Message, field: FieldDescriptor) -> bool:
    return bool(message.HasField(field.name) if field.has_presence else getattr(message, field.name))


def _resolved(asked: settings_pb2.RenderSettings) -> settings_pb2.RenderSettings:
    """The settings that every integrator has, with the usual values where `asked` says nothing
    (proto/wire/settings.h)."""
    settings = settings_pb2.RenderSettings()
    settings.CopyFrom(asked)
    for field in settings.DESCRIPTOR.fields:
        if field.message_type or _is_set(settings, field):
            continue
        usual = field.GetOptions().Extensions[setting_pb2.setting].usual
        if field.enum_type:
            setattr(settings, field.name, 1)
        elif usual:
            setattr(settings, field.name, type(getattr(settings, field.name))(usual))
    settings.max_depth = min(settings.max_depth, _MAX_DEPTH)
    return settings


def _copy_by_name(settings: settings_pb2.RenderSettings, part: Message) -> None:
    """proto/wire/resolve_settings.cpp"""
    for field in part.DESCRIPTOR.fields:
        source = settings.DESCRIPTOR.fields_by_name.get(field.name)
        if source and not source.message_type and _is_set(settings, source):
            setattr(part, field.name, getattr(settings, field.name))


def _has_borders(view: job_pb2.JobSpec.View) -> bool:
    """Whether a tile takes samples beyond its edges."""
    shares = view.path_sharing not in (
        settings_pb2.PATH_SHARING_UNSPECIFIED,
        settings_pb2.PATH_SHARING_OFF,
    )
    return shares or view.reconstruction == settings_pb2.RECONSTRUCTION_SCATTER


def _samples_per_unit(spec: job_pb2.JobSpec) -> int:
    spp, side, crop = spec.samples.spp, spec.cut.tile_size, spec.cut.crop
    if spec.samples.noise:
        return _ceil_power(spp)
    longer = _floor_power(1 + len(spec.view.layers) * 3 // 4)
    if spec.view.lens_ghosts == settings_pb2.LENS_GHOSTS_LIGHTS:
        passes = _floor_power(max(1, _SAMPLES_PER_PASSES // (spec.view.width * spec.view.height)))
        return min(passes * longer, _ceil_power(spp))
    tiles = (-(-(crop.x1 - crop.x0) // side) + 1) * (-(-(crop.y1 - crop.y0) // side) + 1)
    wanted = _floor_power(_SAMPLES_PER_UNIT // (side * side))
    fewest = _ceil_power(-(-(tiles * spp) // _USUAL_UNITS))
    samples = min(max(wanted, fewest), _ceil_power(spp))
    if _has_borders(spec.view):
        samples = max(samples, _LEAST_BORDERED_SAMPLES)
    return min(samples * longer, _ceil_power(spp))


def _finds_ghosts_of_lights(camera: camera_pb2.Camera) -> bool:
    """has_ghosts() of client/command/jobs/job_settings.cpp"""
    others = camera.near_clip or camera.far_clip or camera.HasField("distortion") or camera.HasField("shutter")
    return camera.lens.ghosts and not others


def _sends_light_into_lens(asked: settings_pb2.RenderSettings, scene: Scene, integrator: str) -> bool:
    """resolve_lens_ghosts() of client/command/jobs/job_settings.cpp"""
    if asked.lens_ghosts not in (settings_pb2.LENS_GHOSTS_UNSPECIFIED, settings_pb2.LENS_GHOSTS_AUTO):
        return asked.lens_ghosts == settings_pb2.LENS_GHOSTS_LIGHTS
    cameras = [scene.message.camera, *scene.message.views]
    return (
        any(_finds_ghosts_of_lights(camera) for camera in cameras)
        and integrator in ("path", "volpath")
        and not asked.noise
        and not asked.layers
        and asked.reconstruction != settings_pb2.RECONSTRUCTION_SCATTER
        and asked.path_sharing <= settings_pb2.PATH_SHARING_OFF
        and asked.direct_light != settings_pb2.DIRECT_LIGHT_BSDF
    )


def make_spec(
    scene: Scene,
    user: str,
    *,
    aovs: Sequence[str] = (),
    crop: tuple[int, int, int, int] | None = None,
    resolution: tuple[int, int] | None = None,
) -> tuple[job_pb2.JobSpec, list[Blob]]:
    """The job of the scene with its settings, and the blobs that it needs, the scene's own last.

    Warns, in the name of its caller's caller, where pixels would share light but for layers or the variance."""
    checked(scene.message)
    asked = scene.message.settings
    integrator = asked.integrator or "path"
    if integrator not in DIRECT:
        raise ValueError(f"integrator '{integrator}' is for the program: {', '.join(DIRECT)} were expected")
    film = scene.message.film
    width, height = resolution or (film.width, film.height)
    if not (0 < width <= 1_000_000 and 0 < height <= 1_000_000 and width * height <= 2**32):
        raise ValueError(
            f"the film has {width} x {height} pixels; 1 to 1000000 each way, and at most 2^32 in all, are possible"
        )
    unknown = sorted(set(aovs) - set(AOVS))
    if unknown:
        raise ValueError(f"there is no AOV '{unknown[0]}'; there are {', '.join(AOVS)}")

    spec = job_pb2.JobSpec()
    settings = _resolved(asked)
    for part in (spec.content.algorithms, spec.view, spec.samples):
        _copy_by_name(settings, part)
    view = spec.view
    view.width, view.height = width, height
    view.aovs.extend(sorted({AOVS[aov] for aov in aovs}))  # type: ignore[arg-type]
    if view.sampler == settings_pb2.SAMPLER_Z_SOBOL:
        view.sample_bits = (spec.samples.spp - 1).bit_length()
    view.layers.extend(asked.layers)
    in_passes = _sends_light_into_lens(asked, scene, integrator)
    if in_passes:
        view.lens_ghosts = settings_pb2.LENS_GHOSTS_LIGHTS
    elif view.lens_ghosts == settings_pb2.LENS_GHOSTS_AUTO:
        view.ClearField("lens_ghosts")
    if settings.reconstruction == settings_pb2.RECONSTRUCTION_AUTO:
        gains = _gains_by_scattering(film.filter) and not in_passes
        view.reconstruction = (
            settings_pb2.RECONSTRUCTION_SCATTER if gains else settings_pb2.RECONSTRUCTION_SAMPLE
        )
    if settings.path_sharing == settings_pb2.PATH_SHARING_AUTO:
        can_share = integrator in ("path", "volpath") and not in_passes
        cause = "layers" if asked.layers else "the AOV variance" if "variance" in aovs else ""
        if not can_share or cause:
            view.path_sharing = settings_pb2.PATH_SHARING_OFF
        if can_share and cause and view.max_depth >= 2:
            warnings.warn(
                f"pixels do not share the light of their paths, because of {cause}: the picture may have several "
                "times the variance; render it in a job of its own, or set settings.path_sharing to "
                "PATH_SHARING_OFF",
                stacklevel=3,
            )

    x0, y0, x1, y1 = crop or (0, 0, width, height)
    if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
        raise ValueError(f"the crop {crop} is empty, or not within the film")
    spec.cut.crop.CopyFrom(job_pb2.PixelRect(x0=x0, y0=y0, x1=x1, y1=y1))
    spec.cut.tile_size = _BORDERED_TILE if _has_borders(view) else _TILE
    spec.cut.samples_per_unit = _samples_per_unit(spec)
    if scene.message.views:
        spec.cut.views = 1 + len(scene.message.views)
    if asked.noise:
        parts = min(max((x1 - x0) * (y1 - y0) // _PILOT_PIXELS, 1), _MOST_PILOT_PARTS)
        spec.cut.phases.add(name="noise", parts=parts, merge_width=64)

    data = scene.message.SerializeToString(deterministic=True)
    own = Blob(data, hashlib.sha256(data).hexdigest(), "")
    blobs = [*scene.blobs.values(), own]
    spec.content.scene = own.digest
    spec.farm.name = scene.message.name
    spec.farm.user = user
    spec.farm.blobs.extend(blob.ref() for blob in [own, *scene.blobs.values()])
    return spec, blobs
