// Closed forms for shapes with an object space of their own.
#pragma once

#include <optional>
#include <vector>

#include "render/query/maps.h"
#include "render/query/query_kernel.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// Whether a shape bounds a solid: nullopt where its table does not say (meshes, and kinds that are not known
/// here). Implicit surfaces and grids count as closed; where their bounds cut them they are not.
std::optional<bool> bounds_solid(const ShapeTable& table, const ShapeRecord& shape,
                                 const QueryKernel& kernel);

/// Whether a point of the space that the shape is placed in is within its solid; nullopt where bounds_solid()
/// is not true.
std::optional<bool> in_solid(const ShapeTable& table, const ShapeRecord& shape, const QueryKernel& kernel,
                             const V3d& p);

/// The greatest a . p over the shape's points p of object space: for tight bounds. nullopt where there is no
/// formula.
std::optional<double> support(const ShapeTable& table, const ShapeRecord& shape, const QueryKernel& kernel,
                              const V3d& a);

/// The map of shapes that are in ShapeTable::quadrics; the identity for others.
ExactAffine placed_from_object(const ShapeTable& table, const ShapeRecord& shape);

/// A plane polygon, its corners in order.
using Face = std::vector<V3d>;

/// The faces, in object space, of shapes that have plane ones alone: boxes, polyhedra, polygons, and the
/// plane of a half-space as far as it goes. None for others.
std::vector<Face> plane_faces(const ShapeTable& table, const ShapeRecord& shape);

}  // namespace tessera::render
