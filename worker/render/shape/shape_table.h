// Geometry as the kernels read it: plain arrays, filled by scene/, the same for every ISA.
//
// Positions are in render space: world space minus its origin (Scene.render_origin, else where the camera
// stands; subtracted in double), so that floats are finest there. Shapes of an Object stay in instance space;
// an InstanceRecord places them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "render/core/affine_data.h"
#include "render/core/big_array.h"
#include "render/shape/csg/csg_record.h"
#include "render/shape/curve_table.h"
#include "render/shape/implicit/implicit_record.h"

namespace tessera::render {

/// Each kind but kTriangles and kCurves has a model, at the end of whose file it is named; kinds from kCount
/// on are those that add_analytic_shape() gives.
enum class ShapeKind : std::int32_t {
  kTriangles,
  kSphere,
  kDisk,
  kCylinder,
  kSdfGrid,
  kCurves,
  kHalfSpace,
  kFrustum,
  kPolygon,
  kBox,
  kPolyhedron,
  kTorus,
  kImplicit,
  kCsg,
  kCount
};

/// Bits of ShapeRecord::flags.
enum ShapeFlags : std::int32_t {
  kFlipNormal = 1,  // The kind's own geometric normal is reversed; without meaning for kTriangles, which
                    // are wound so that cross(p1 - p0, p2 - p0) is the geometric normal.
  kHasNormals = 2,  // shading normals
  kHasUvs = 4,
  kHasAlpha = 8,       // opacity below 1 somewhere: its Embree geometry has filter functions
  kMediumBorder = 16,  // interior and exterior differ
  kDeforms = 32,       // kTriangles, kCurves: vertices, or control points, move (key_segments)
};

/// One shape; its index is its Embree geometry id, in whichever Embree scene it lies. The kernels read the
/// first two rows of four members each at once.
struct ShapeRecord {
  ShapeKind kind = ShapeKind::kTriangles;
  std::int32_t material = 0;
  std::int32_t flags = 0;
  std::int32_t first_light = -1;  // light of primitive 0; the others follow. -1: does not emit
  // kTriangles
  std::int32_t first_triangle = 0;  // index in ShapeTable::triangles
  std::int32_t first_vertex = 0;    // index in ShapeTable::vertices
  std::int32_t quadric = 0;         // kSdfGrid: in ShapeTable::sdf_grids; kCurves: in ShapeTable::curves;
                                    // kImplicit: in ShapeTable::implicits; kCsg: in ShapeTable::csgs;
                                    // other analytic shapes: in ShapeTable::quadrics
  std::int32_t alpha_texture = -1;
  float alpha = 1;
  std::int32_t triangle_count = 0;
  std::int32_t vertex_count = 0;
  // With kMediumBorder: what is behind the surface and in front of it; -1: nothing.
  std::int32_t interior = -1, exterior = -1;
  // In the scene, from 1 on: its own shapes, then those of its objects, one object after the other. The item
  // buffer has these.
  std::int32_t number = 0;
  // kTriangles with kDeforms: vertices of the keys, at evenly spaced times from 0 to 1, follow one another:
  // those of key k begin at first_vertex + k * vertex_count. In between, all of a vertex is linear.
  std::int32_t key_segments = 0;
  std::int32_t padding = 0;
};
static_assert(sizeof(ShapeRecord) == 64);

/// Whether its bounds say nothing about the size of the scene.
inline bool is_unbounded(const ShapeRecord& shape) { return shape.kind == ShapeKind::kHalfSpace; }

/// All of a vertex in half a cache line: a hit touches three lines for it (measured: docs/decisions/0005).
struct alignas(32) Vertex {
  float position[3] = {0, 0, 0};
  float u = 0;
  float normal[3] = {0, 0, 0};  // shading normal, with kHasNormals
  float v = 0;                  // u and v with kHasUvs
};

/// A corner of a polygon in z = 0 (x, y), or a plane of a polyhedron: all points p of the solid have
/// p . normal <= offset. Object space.
struct Facet {
  float normal[3] = {0, 0, 0};
  float offset = 0;
};

/// A shape with an object space of its own: a sphere about the origin, a disk in z = height or a cylinder
/// about the z axis [pbrt-v4]; and those that are of size 1 in theirs. kHalfSpace: z <= 0. kFrustum: about
/// the z axis, from z = -1 to 1, the larger radius 1. kPolygon: in z = 0. kBox: the cube from -1 to 1.
/// kPolyhedron: in that cube. kTorus: about the z axis, its circle of radius 1.
struct QuadricRecord {
  Affine render_from_object;
  Affine object_from_render;
  float radius = 1;        // frustum: at z = -1; half-space: as far as its plane goes
  float inner_radius = 0;  // disk; torus: of its tube
  float height = 0;        // disk
  float z_min = -1, z_max = 1, phi_max = 6.28318530718f;
  std::int32_t partial = 0;  // a sphere that is not whole, or one of the others cut by phi_max
  std::int32_t maps_uv =
      0;  // (u', v') = (uv_map[0] u + uv_map[1] v + uv_map[2], uv_map[3] u + ...) of pbrt's parameters
  float uv_map[6] = {1, 0, 0, 0, 1, 0};
  float top_radius = 1;                           // frustum: at z = 1
  std::int32_t capped = 0;                        // frustum
  std::int32_t first_facet = 0, facet_count = 0;  // polygon, polyhedron: in ShapeTable::facets
};

/// The zero level of samples that are trilinear in between. They fill the unit cube of object space, the
/// first and last along an axis on its faces.
struct SdfGridRecord {
  Affine render_from_object;
  Affine object_from_render;
  std::int32_t size[3] = {2, 2, 2};
  std::int32_t smooth_normals = 0;
  std::vector<float> samples;  // x fastest
  std::vector<std::int32_t>
      voxels;  // samples at the lower corners of the voxels that hold a piece of the surface: primitives
};

struct InstanceRecord {
  Affine render_from_instance;  // map of an instance; of one that moves, the map when the shutter opens
  Affine instance_from_render;
  std::int32_t object = 0;       // index in ShapeTable::objects
  std::int32_t first_step = 0;   // index in ShapeTable::motion_steps of an instance that moves
  std::int32_t segments = 0;     // number of segments between its steps; 0: it stands still
  std::int32_t number = 0;       // number in the scene, from 1 on; 0: a shape of the scene's own that moves
  std::int64_t first_place = 0;  // number of its object's place, counted from the first of its neighbours
  std::int32_t padding[2] = {};
};
static_assert(sizeof(InstanceRecord) == 128);

/// Shapes [first_shape, first_shape + shape_count) and other objects, placed by ShapeTable::inner
/// [first_inner, first_inner + inner_count): a group that instances place.
struct ObjectRange {
  std::int32_t first_shape = 0;
  std::int32_t shape_count = 0;
  std::int32_t first_inner = 0;
  std::int32_t inner_count = 0;
};

struct ShapeTable {
  std::vector<ShapeRecord> shapes;
  // The first shapes stand in the world, those of objects follow. The last are the solids that kCsg combines,
  // which rays meet as parts of it alone.
  std::int32_t world_shape_count = 0;
  std::vector<ObjectRange> objects;  // objects, each after those that it places
  std::vector<QuadricRecord> quadrics;
  std::vector<Facet> facets;
  std::vector<SdfGridRecord> sdf_grids;
  std::vector<CurvesRecord> curves;
  std::vector<ImplicitRecord> implicits;
  std::vector<CsgRecord> csgs;
  std::vector<InstanceRecord> instances;  // instance i has Embree geometry id shapes.size() + i
  // Instances in objects, where they are not flattened (place.h). The space of the object that they are in
  // is what their members call render space.
  std::vector<InstanceRecord> inner;
  std::vector<Affine> motion_steps;   // render_from_instance of those that move, see core/motion.h
  BigArray<std::uint32_t> triangles;  // three vertex indices each, counted from first_vertex
  BigArray<Vertex> vertices;

  /// Shapes that rays meet by themselves: all but the solids of combinations.
  std::span<const ShapeRecord> placed() const {
    std::size_t solids = 0;
    for (const CsgRecord& csg : csgs) solids += csg.solids.size();
    return std::span(shapes).first(shapes.size() - solids);
  }
  bool nested() const { return !inner.empty(); }
  /// Whether places of points depend on the time.
  bool moves() const {
    return !motion_steps.empty() || std::ranges::any_of(shapes, [](const ShapeRecord& shape) {
      return (shape.flags & kDeforms) != 0;
    });
  }
  std::span<const InstanceRecord> inner_of(const ObjectRange& object) const {
    return std::span(inner).subspan(static_cast<std::size_t>(object.first_inner),
                                    static_cast<std::size_t>(object.inner_count));
  }
};

/// Whether the object is one such shape alone. Objects that hold others have none.
inline bool is_unbounded(const ShapeTable& table, const ObjectRange& object) {
  return object.shape_count > 0 && is_unbounded(table.shapes[static_cast<std::size_t>(object.first_shape)]);
}
inline bool is_unbounded(const ShapeTable& table, const InstanceRecord& instance) {
  return is_unbounded(table, table.objects[static_cast<std::size_t>(instance.object)]);
}

inline bool any_unbounded(const ShapeTable& table) {
  return std::ranges::any_of(table.placed(), [](const ShapeRecord& shape) { return is_unbounded(shape); });
}

}  // namespace tessera::render
