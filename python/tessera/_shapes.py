"""Shapes of scenes, and objects: groups of them that are placed several times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from tessera._mesh import encode_mesh
from tessera._scene_message import SceneMessage
from tessera._values import (
    Amount,
    Color,
    Material,
    Vector,
    amount_message,
    checked,
    matrix_message,
    spectrum_message,
    translate,
)
from tessera.v1 import scene_pb2, shape_pb2, value_pb2


class Shapes(SceneMessage):
    """The part of a scene that has extent."""

    def shape(
        self,
        message: shape_pb2.Shape,
        material: Material | None = None,
        transform: npt.ArrayLike | None = None,
        emission: Color | None = None,
        two_sided: bool = False,
        name: str = "",
        to: scene_pb2.Object | None = None,
        amount: Amount | None = None,
    ) -> shape_pb2.Shape:
        """Adds any shape of the scene language to the scene, or `to` an object. `transform`: world from
        object; `emission`: radiance on the side of the normal, or on both, in W/(m^2 sr), or the colour alone
        where there is an `amount` ("lm", "W", "cd/m2", ...)."""
        message.material = material or ""
        message.name = name
        if transform is not None:
            message.world_from_object.CopyFrom(matrix_message(transform) or value_pb2.Matrix())
        if emission is not None:
            radiance = spectrum_message(1.0 if isinstance(emission, str) else emission)
            message.area_light.radiance.CopyFrom(radiance)
            message.area_light.texture = emission if isinstance(emission, str) else ""
            message.area_light.two_sided = two_sided
            if amount is not None:
                message.area_light.amount.CopyFrom(amount_message(amount))
        shapes = self.message.shapes if to is None else to.shapes
        shapes.append(checked(message))
        added: shape_pb2.Shape = shapes[-1]  # a copy
        return added

    def mesh(
        self,
        vertices: npt.ArrayLike,
        triangles: npt.ArrayLike,
        material: Material | None = None,
        *,
        normals: npt.ArrayLike | None = None,
        uvs: npt.ArrayLike | None = None,
        transform: npt.ArrayLike | None = None,
        emission: Color | None = None,
        two_sided: bool = False,
        name: str = "",
        to: scene_pb2.Object | None = None,
        later: Sequence[tuple[npt.ArrayLike, npt.ArrayLike | None]] = (),
    ) -> shape_pb2.Shape:
        """Triangles: `vertices` (n, 3), `triangles` (m, 3) with indices of vertices, which run
        counterclockwise seen from outside; `normals` (n, 3) and `uvs` (n, 2), v upwards from the picture's
        lower edge. `later` has the vertices and normals of a mesh that deforms, at evenly spaced times until the
        shutter closes."""
        file = f"{name or 'mesh'}.mesh"
        mesh = shape_pb2.TriangleMesh(blob=self._add_blob(encode_mesh(vertices, triangles, normals, uvs), file))
        for places, turned in later:
            mesh.later_blobs.append(self._add_blob(encode_mesh(places, triangles, turned, uvs), file))
        message = shape_pb2.Shape(mesh=mesh)
        return self.shape(message, material, transform, emission, two_sided, name, to)

    def sphere(
        self,
        radius: float,
        center: Vector = (0, 0, 0),
        material: Material | None = None,
        emission: Color | None = None,
        name: str = "",
        amount: Amount | None = None,
    ) -> shape_pb2.Shape:
        message = shape_pb2.Shape(sphere=shape_pb2.Sphere(radius=radius))
        x, y, z = (float(c) for c in center)
        return self.shape(message, material, translate(x, y, z), emission, name=name, amount=amount)

    def box(
        self, low: Vector, high: Vector, material: Material | None = None, name: str = ""
    ) -> shape_pb2.Shape:
        message = shape_pb2.Shape(
            box=shape_pb2.Box(low=[float(c) for c in low], high=[float(c) for c in high])
        )
        return self.shape(message, material, name=name)

    def rectangle(
        self,
        corners: Sequence[Vector],
        material: Material | None = None,
        emission: Color | None = None,
        two_sided: bool = False,
        name: str = "",
        amount: Amount | None = None,
    ) -> shape_pb2.Shape:
        """A polygon, its corners counterclockwise about its normal; u goes along its first edge."""
        flat = [float(c) for corner in corners for c in corner]
        message = shape_pb2.Shape(polygon=shape_pb2.Polygon(corners=flat))
        return self.shape(message, material, None, emission, two_sided, name, amount=amount)

    def object(self, name: str) -> scene_pb2.Object:
        """A group of shapes (`to`), placed by `instance`."""
        self.message.objects.append(scene_pb2.Object(name=name))
        added: scene_pb2.Object = self.message.objects[-1]
        return added

    def instance(self, object: scene_pb2.Object, world_from_instance: npt.ArrayLike) -> None:
        message = scene_pb2.Instance(
            object=object.name, world_from_instance=matrix_message(world_from_instance)
        )
        self.message.instances.append(checked(message))
