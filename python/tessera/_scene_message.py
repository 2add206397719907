"""The message that a scene fills, and the bytes that it refers to."""

from __future__ import annotations

from tessera._values import Blob
from tessera.v1 import blob_ref_pb2, scene_pb2


class SceneMessage:
    """A scene without a way to add to it: that is what materials, shapes, lights and cameras bring."""

    def __init__(self, name: str = "scene") -> None:
        self.message = scene_pb2.Scene(name=name)
        self.blobs: dict[str, Blob] = {}  # by digest

    def _add_blob(self, data: bytes, path: str) -> blob_ref_pb2.BlobRef:
        blob = Blob.of(data, path)
        self.blobs.setdefault(blob.digest, blob)
        return blob.ref()
