"""Tessera from Python: scenes in code, jobs of a farm, pictures as arrays (docs/python.md)."""

from tessera._measure import Figure, Grid, Measured, Meter, Surface, measure, meters
from tessera._wire import JobFailed, NotFound, Refused, TesseraError, Unreachable
from tessera.farm import Farm, Job, Progress, Restart, TileUpdate
from tessera.picture import to_srgb, write_png
from tessera.results import Picture, Rect
from tessera.scene import Material, Scene, Texture, look_at, translate

__all__ = [
    "Farm",
    "Figure",
    "Grid",
    "Job",
    "JobFailed",
    "Material",
    "Measured",
    "Meter",
    "NotFound",
    "Picture",
    "Progress",
    "Rect",
    "Refused",
    "Restart",
    "Scene",
    "Surface",
    "TesseraError",
    "Texture",
    "TileUpdate",
    "Unreachable",
    "look_at",
    "measure",
    "meters",
    "to_srgb",
    "translate",
    "write_png",
]
