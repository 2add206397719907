// Shapes of .pbrt files that pbrt-v4 does not have: named like the messages that they become.
#pragma once

#include "import/pbrt/shapes/shapes.h"

namespace tessera::client::pbrt {

// Numbers are checked where a scene is built, which names the shape; here only that the parameters are there.
ShapeResult write_half_space(ValueReader& values, v1::Shape& shape);
ShapeResult write_cone(ValueReader& values, v1::Shape& shape);
ShapeResult write_polygon(ValueReader& values, v1::Shape& shape);
ShapeResult write_box(ValueReader& values, v1::Shape& shape);
ShapeResult write_polyhedron(ValueReader& values, v1::Shape& shape);
ShapeResult write_torus(ValueReader& values, v1::Shape& shape);
ShapeResult write_ellipsoid(ValueReader& values, v1::Shape& shape);

/// Area in the world of a box or a polygon.
double area_of_flat(const v1::Shape& shape, const Imath::M44d& world_from_object);

}  // namespace tessera::client::pbrt
