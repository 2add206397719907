#include "render/query/containment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace tessera::render {
namespace {

/// Directions that no scene is built along. Parity is that of the first; the others are asked where a closed
/// shape's two tests disagree, and the majority counts.
constexpr std::array<V3d, 3> directions() {
  return {V3d(0.5383651, 0.2217943, 0.8129983), V3d(-0.7720651, 0.5910893, 0.2334137),
          V3d(0.1837263, -0.8841439, -0.4296061)};
}

}  // namespace

Inside PointReport::inside() const {
  bool unsure = false;
  for (const Containment& c : shapes) {
    if (c.agree() && c.by_parity) return Inside::kInside;
    unsure = unsure || (!c.agree() && (c.closed || std::abs(c.winding) >= 0.25));
  }
  return unsure ? Inside::kUnsure : Inside::kOutside;
}

const QueryScene::MeshFacts& QueryScene::facts(std::int32_t mesh) const {
  MeshFacts& facts = *mesh_facts_[static_cast<std::size_t>(mesh)];
  std::call_once(facts.once, [&] {
    facts.winding = std::make_unique<const WindingTree>(table(), record(mesh), parts_.threads);
    facts.closed = inspect_mesh(table(), record(mesh)).closed;
  });
  return facts;
}

/// One point. Render space.
class ContainmentSearch {
 public:
  ContainmentSearch(const QueryScene& scene, const V3d& p) : scene_(scene), p_(p) {}

  PointReport run() {
    count(directions()[0], counts_);
    for (const auto& [place, count] : counts_) candidates_.emplace(place, Containment{});
    add_shapes_about();
    PointReport report;
    report.medium = medium();
    bool in_doubt = false;
    for (auto& [place, c] : candidates_) {
      c = test(place);
      in_doubt = in_doubt || (c.closed && !c.agree());
    }
    if (in_doubt) ask_again();
    for (const auto& [place, c] : candidates_) {
      if (c.by_parity || c.by_winding()) report.shapes.push_back(c);
    }
    std::ranges::stable_sort(report.shapes, {}, [](const Containment& c) { return c.leaves_at; });
    return report;
  }

 private:
  /// A shape in an instance, or in the world.
  using Place = std::pair<std::int32_t, std::int32_t>;  // instance, shape
  struct Count {
    int crossings = 0;
    double first = HUGE_VAL;
  };

  void count(const V3d& direction, std::map<Place, Count>& counts) {
    const ExactRay ray{{p_.x, p_.y, p_.z}, {direction.x, direction.y, direction.z}};
    scene_.parts_.kernel->find_crossings(scene_.structure_, ray, scene_.parts_.time, crossings_);
    for (const Crossing& c : crossings_) {
      Count& of_shape = counts[{c.instance, c.shape}];
      ++of_shape.crossings;
      of_shape.first = std::min(of_shape.first, c.t);
    }
  }

  /// Shapes in whose boxes the point is, and solids that have no end.
  void add_shapes_about() {
    const auto about = [](const Primitive& box, const V3d& p) {
      for (int k = 0; k < 3; ++k) {
        if (!(p[k] >= double{box.corners[0][k]} && p[k] <= double{box.corners[1][k]})) return false;
      }
      return true;
    };
    const auto add = [&](std::int32_t instance, std::int32_t shape) {
      candidates_.emplace(Place{instance, shape}, Containment{});
    };
    const ShapeTable& table = scene_.table();
    const auto add_instance = [&](std::int32_t instance, bool everywhere) {
      const V3d own = apply(scene_.structure_.instance_from_render(instance, scene_.parts_.time), p_);
      const InstanceRecord& record = table.instances[static_cast<std::size_t>(instance)];
      for (const Primitive& box : scene_.boxes_of_objects_[static_cast<std::size_t>(record.object)]) {
        if (everywhere || about(box, own)) add(instance, box.shape);
      }
    };
    for (const std::int32_t shape : scene_.half_spaces_) add(-1, shape);
    for (const std::int32_t instance : scene_.half_space_instances_) add_instance(instance, true);
    const Bvh& tree = scene_.shape_boxes_.tree;
    if (tree.nodes.empty()) return;
    std::int32_t stack[kBvhDepth + 1];
    int waiting = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
      const BvhNode& node = tree.nodes[static_cast<std::size_t>(stack[--waiting])];
      for (int c = 0; c < 2; ++c) {
        bool inside = true;
        for (int k = 0; k < 3; ++k)
          inside = inside && p_[k] >= double{node.planes[k][c]} && p_[k] <= double{node.planes[k][2 + c]};
        if (!inside) continue;
        if (node.child[c] >= 0) stack[waiting++] = node.child[c];
        for (std::int32_t i = 0; node.child[c] < 0 && i < node.count[c]; ++i) {
          const Primitive& box = scene_.shape_boxes_.primitives[static_cast<std::size_t>(~node.child[c] + i)];
          if (!about(box, p_)) continue;
          if (box.kind == PrimitiveKind::kInstance) {
            add_instance(box.number, false);
          } else {
            add(-1, box.shape);
          }
        }
      }
    }
  }

  /// The map into the space that the shape is placed in.
  V3d own_point(std::int32_t instance) const {
    return instance < 0 ? p_
                        : apply(scene_.structure_.instance_from_render(instance, scene_.parts_.time), p_);
  }

  bool odd(const Place& place, const std::map<Place, Count>& counts, const V3d& direction) const {
    const auto found = counts.find(place);
    const bool crossings_odd = found != counts.end() && found->second.crossings % 2 == 1;
    // The end of a line that stays in a half-space is in it.
    const ShapeRecord& shape = scene_.record(place.second);
    return crossings_odd != (is_unbounded(shape) && ends_in_half_space(place, direction));
  }

  bool ends_in_half_space(const Place& place, const V3d& direction) const {
    ExactAffine own = placed_from_object(scene_.table(), scene_.record(place.second));
    if (place.first >= 0)
      own = compose(scene_.structure_.render_from_instance(place.first, scene_.parts_.time), own);
    const ExactAffine from = inverse(own);
    const double* const row = from.m + 8;
    return row[0] * direction.x + row[1] * direction.y + row[2] * direction.z < 0;
  }

  Containment test(const Place& place) const {
    const auto [instance, shape] = place;
    const ShapeRecord& record = scene_.record(shape);
    Containment c;
    c.shape = shape, c.instance = instance;
    const auto found = counts_.find(place);
    c.leaves_at = found == counts_.end() ? HUGE_VAL : found->second.first;
    c.by_parity = odd(place, counts_, directions()[0]);
    if (record.kind == ShapeKind::kTriangles) {
      const QueryScene::MeshFacts& facts = scene_.facts(shape);
      c.closed = facts.closed;
      c.winding = facts.winding->at(own_point(instance));
      return c;
    }
    c.closed = bounds_solid(scene_.table(), record, *scene_.parts_.kernel).value_or(true);
    const auto within = in_solid(scene_.table(), record, *scene_.parts_.kernel, own_point(instance));
    // Solids without a formula: what the line's crossings say, with their directions.
    c.winding = within ? (*within ? 1 : 0) : c.closed ? crossed_out(place) : 0;
    if (record.flags & kFlipNormal) c.winding = within ? -c.winding : c.winding;
    return c;
  }

  /// How often the line leaves the shape, less how often it enters.
  double crossed_out(const Place& place) const {
    const V3d d = directions()[1];
    const ExactRay ray{{p_.x, p_.y, p_.z}, {d.x, d.y, d.z}};
    std::vector<Crossing> crossings;
    scene_.parts_.kernel->find_crossings(scene_.structure_, ray, scene_.parts_.time, crossings);
    std::erase_if(crossings, [&](const Crossing& c) { return Place{c.instance, c.shape} != place; });
    std::vector<SurfaceHit> hits;
    scene_.describe(ray, crossings, hits);
    double sum = 0;
    for (const SurfaceHit& hit : hits) sum += hit.from_front ? -1 : 1;
    return sum;
  }

  void ask_again() {
    std::map<Place, Count> second, third;
    count(directions()[1], second);
    count(directions()[2], third);
    for (auto& [place, c] : candidates_) {
      if (!c.closed) continue;
      c.by_parity = int{c.by_parity} + int{odd(place, second, directions()[1])} +
                        int{odd(place, third, directions()[2])} >=
                    2;
    }
  }

  /// That on the near side of the first border of media along the line.
  std::string medium() {
    for (const Crossing& c : crossings_) {
      if ((scene_.record(c.shape).flags & kMediumBorder) == 0) continue;
      const V3d d = directions()[0];
      std::vector<SurfaceHit> hit;
      scene_.describe({{p_.x, p_.y, p_.z}, {d.x, d.y, d.z}}, {c}, hit);
      const ShapeNames& names = scene_.names(c.shape);
      return hit[0].from_front ? names.exterior_medium : names.interior_medium;
    }
    return scene_.far_medium_;
  }

  const QueryScene& scene_;
  const V3d p_;
  std::vector<Crossing> crossings_;
  std::map<Place, Count> counts_;
  std::map<Place, Containment> candidates_;
};

PointReport QueryScene::at(const V3d& p) const { return ContainmentSearch(*this, p - parts_.origin).run(); }

std::string QueryScene::medium_far_away() const {
  const V3d o = parts_.camera - parts_.origin, d = directions()[0];
  const ExactRay ray{{o.x, o.y, o.z}, {d.x, d.y, d.z}};
  std::vector<Crossing> crossings;
  parts_.kernel->find_crossings(structure_, ray, parts_.time, crossings);
  std::erase_if(crossings, [&](const Crossing& c) { return (record(c.shape).flags & kMediumBorder) == 0; });
  if (crossings.empty()) return parts_.camera_medium;
  std::vector<SurfaceHit> hits;
  describe(ray, {crossings.back()}, hits);
  return hits[0].from_front ? names(crossings.back().shape).interior_medium
                            : names(crossings.back().shape).exterior_medium;
}

}  // namespace tessera::render
