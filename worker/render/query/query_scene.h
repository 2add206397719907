// Questions about a scene's geometry, answered in double precision. Positions are in world space.
//
// The geometry is the one that is rendered: coordinates are floats about the origin of render space. Opacity
// does not count: holes that alpha cuts are closed. Curves, which face whoever looks, are left out.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/query/mesh_defects.h"
#include "render/query/query_kernel.h"
#include "render/query/solid.h"

namespace tessera::render {

/// How a shape of ShapeTable is called.
struct ShapeNames {
  std::string name, material;                    // empty: none was given
  std::string interior_medium, exterior_medium;  // the medium behind the surface, the one in front of it
  std::int32_t number = 0;                       // number in the scene, from 1 on
};

/// A place on a surface.
struct SurfaceHit {
  double t = 0;  // ray parameter, or distance
  V3d p{0, 0, 0};
  V3d normal{0, 0, 0};     // geometric, unit; single precision
  double u = 0, v = 0;     // single precision
  bool from_front = true;  // the ray goes against the normal; or the point asked for is on its side
  std::int32_t shape = -1, primitive = 0, instance = -1;  // indices
};

/// How a point lies to one shape.
struct Containment {
  std::int32_t shape = -1, instance = -1;
  double leaves_at = 0;  // distance along one line to where it crosses the shape; infinite: nowhere
  bool by_parity = false;
  double winding = 0;  // 1: in a solid, 0: outside; in between where a mesh is open
  bool closed = true;  // the shape bounds a solid

  bool by_winding() const { return winding >= 0.5 || winding <= -0.5; }
  bool agree() const { return by_parity == by_winding(); }
};

enum class Inside : std::uint8_t {
  kOutside,
  kInside,  // inside a shape, by both tests
  kUnsure   // not certain: the tests disagree about a shape that is closed, or that goes at least a quarter
            // around the point (a sheet that a line happens to cross is no reason for doubt)
};

struct PointReport {
  std::vector<Containment> shapes;  // shapes that the point is in by either test, the innermost first
  std::string medium;               // there; empty: none

  Inside inside() const;
};

/// The closest place, and by how much a shape may be closer for which there is no formula: 0 where the answer
/// is exact.
struct ClosestReport {
  std::optional<SurfaceHit> hit;
  double error = 0;
};

struct BoundsReport {
  std::int32_t shape = -1, instance = -1;  // a shape of the world's own, or an instance; both -1: the scene
  V3d low, high;                           // low above high where there is nothing
  bool tight = true;                       // No smaller box holds it, but for rounding.
  bool unbounded = false;                  // a half-space: it does not count for the scene
};

struct ShapeReport {
  std::int32_t shape = -1;
  bool is_mesh = false;
  MeshReport mesh;  // other shapes: `closed` alone
};

/// Immutable, and safe to use from any number of threads at once.
class QueryScene {
 public:
  struct Parts {
    std::shared_ptr<const ShapeTable> shapes;
    std::vector<ShapeNames> names;  // names of each shape
    V3d origin{0, 0, 0};            // origin of render space, in the world
    V3d camera{0, 0, 0};            // position in the world
    std::string camera_medium;
    const QueryKernel* kernel = nullptr;
    AnalyticBounds analytic;
    float time = 0;  // 0 (the shutter opens) to 1
    int threads = 1;
  };
  /// ResourceExhausted where there are too many primitives.
  static absl::StatusOr<std::unique_ptr<const QueryScene>> build(Parts parts);
  ~QueryScene();

  const ShapeNames& names(std::int32_t shape) const { return parts_.names[static_cast<std::size_t>(shape)]; }
  /// From 1 on; 0 outside instances, and of shapes of the scene's own that move.
  std::int32_t instance_number(std::int32_t instance) const;

  /// A point of inspect()'s: of a shape of an object it stays in the object's own space.
  V3d in_world(std::int32_t shape, const V3d& p) const {
    return shape < table().world_shape_count ? p + parts_.origin : p;
  }

  /// All places at t > 0 where the ray goes through a surface, in order. One through a shared edge of a mesh
  /// is found once; one that runs within a plane surface does not go through it.
  std::vector<SurfaceHit> hits(const V3d& origin, const V3d& direction) const;
  struct Line {
    V3d origin, direction;
  };
  /// The same of many rays, in less time: what they cross is described sixteen places at a time.
  std::vector<std::vector<SurfaceHit>> hits(std::span<const Line> lines) const;
  PointReport at(const V3d& p) const;
  ClosestReport closest(const V3d& p) const;
  /// Bounds of the scene, then of each shape and instance.
  std::vector<BoundsReport> bounds() const;
  /// Reports on every shape of the scene and its objects.
  std::vector<ShapeReport> inspect() const;
  /// Shapes without a formula for closest(), which knows bounds of their distance alone.
  std::vector<std::int32_t> without_closest() const;
  /// Curves.
  std::vector<std::int32_t> left_out() const;

 private:
  friend class ClosestSearch;
  friend class ContainmentSearch;
  struct MeshFacts;  // facts that at() finds out of a mesh when it first needs them

  explicit QueryScene(Parts parts);

  const ShapeTable& table() const { return *parts_.shapes; }
  const ShapeRecord& record(std::int32_t shape) const {
    return table().shapes[static_cast<std::size_t>(shape)];
  }
  const MeshFacts& facts(std::int32_t mesh) const;
  void describe(const ExactRay& ray, const std::vector<Crossing>& crossings,
                std::vector<SurfaceHit>& hits) const;
  /// One of `rays` and one of `hits` each.
  void describe_all(std::span<const ExactRay* const> rays, std::span<const Crossing> crossings,
                    std::span<SurfaceHit> hits) const;
  void build_boxes();
  std::string medium_far_away() const;

  const Parts parts_;
  QueryStructure structure_;
  // Boxes of whole shapes, to find those that a point may be in: a level over world shapes and instances, and
  // a list for each object.
  Level<Bvh> shape_boxes_;
  std::vector<std::vector<Primitive>> boxes_of_objects_;
  std::vector<std::int32_t> half_spaces_, half_space_instances_;
  std::vector<std::vector<Face>> faces_;  // faces of each shape that has plane ones alone; object space
  std::vector<std::unique_ptr<MeshFacts>> mesh_facts_;
  std::string far_medium_;
};

}  // namespace tessera::render
