"""Tessera from Python: scenes in code, jobs of a farm, pictures as arrays (docs/python.md)."""

from tessera._wire import JobFailed, NotFound, Refused, TesseraError, Unreachable
from tessera.farm import Farm, Job, Progress, Restart, TileUpdate
from tessera.picture import to_srgb, write_png
from tessera.results import Picture, Rect
from tessera.scene import Material, Scene, Texture, look_at, translate

__all__ = [
    "Farm",
    "Job",
    "JobFailed",
    "Material",
    "NotFound",
    "Picture",
    "Progress",
    "Rect",
    "Refused",
    "Restart",
    "Scene",
    "TesseraError",
    "Texture",
    "TileUpdate",
    "Unreachable",
    "look_at",
    "to_srgb",
    "translate",
    "write_png",
]
