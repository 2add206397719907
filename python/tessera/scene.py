"""Scenes that are built in code.

A `Scene` fills a message of Tessera's scene language (proto/tessera/v1/scene.proto), which is open to whoever
wants more than the functions here: `scene.message`. Spaces: world space is any, right-handed or not; matrices are
4 x 4 and act on column vectors; angles are in degrees; colours are linear Rec.709.
"""

from __future__ import annotations

from pathlib import Path

from google.protobuf import text_format

from tessera._cameras import Cameras
from tessera._lights import Lights
from tessera._materials import Materials
from tessera._shapes import Shapes
from tessera._values import Blob, Material, Texture, checked, look_at, translate
from tessera.v1 import blob_ref_pb2, scene_pb2, settings_pb2

__all__ = ["Blob", "Material", "Scene", "Texture", "look_at", "translate"]


class Scene(Materials, Shapes, Lights, Cameras):
    """A scene, and the bytes of its meshes and pictures. Materials and textures are handles: their names."""

    @property
    def settings(self) -> settings_pb2.RenderSettings:
        """How it is rendered where a job does not say: integrator, spp, noise, max_depth, seed ..."""
        return self.message.settings

    def save(self, path: str | Path) -> None:
        """Writes the scene as `.textproto`, and its blobs into a folder beside it, for `tessera render`."""
        path = Path(path)
        folder = path.with_suffix(".blobs")
        folder.mkdir(parents=True, exist_ok=True)
        checked(self.message)
        names = {}
        for blob in self.blobs.values():
            names[blob.digest] = f"{folder.name}/{blob.digest[:16]}{Path(blob.path).suffix}"
            (path.parent / names[blob.digest]).write_bytes(blob.data)
        written = scene_pb2.Scene()
        written.CopyFrom(self.message)
        _name_files(written, names)
        header = "# proto-file: proto/tessera/v1/scene.proto\n# proto-message: tessera.v1.Scene\n"
        path.write_text(header + text_format.MessageToString(written))


def _name_files(message: object, names: dict[str, str]) -> None:
    """References to blobs name files in place of digests."""
    if isinstance(message, blob_ref_pb2.BlobRef):
        if message.digest in names:
            message.path = names[message.digest]
            message.digest, message.size_bytes = "", 0
        return
    for descriptor, value in message.ListFields():  # type: ignore[attr-defined]
        if descriptor.message_type is None:
            continue
        for part in value if descriptor.label == descriptor.LABEL_REPEATED else [value]:
            _name_files(part, names)
