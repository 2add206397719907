// The closest point of all surfaces: a search front to back through the hierarchies of boxes.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>

#include "render/query/nearest_point.h"
#include "render/query/query_scene.h"

namespace tessera::render {
namespace {

double distance_to(const Box& box, const V3d& p) {
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    const double off = std::max({double{box.low[k]} - p[k], p[k] - double{box.high[k]}, 0.0});
    squared += off * off;
  }
  return std::sqrt(squared);
}

bool has_formula(const ShapeTable& table, const ShapeRecord& shape, const QueryKernel& kernel,
                 const ExactAffine& place) {
  if (shape.kind == ShapeKind::kTriangles) return true;
  if (shape.kind == ShapeKind::kSphere && !table.quadrics[static_cast<std::size_t>(shape.quadric)].partial)
    return true;
  return !plane_faces(table, shape).empty() ||
         nearest_on_round({0, 0, 0}, place, table, shape, kernel).has_value();
}

}  // namespace

/// One point. Render space.
class ClosestSearch {
 public:
  ClosestSearch(const QueryScene& scene, const V3d& p) : scene_(scene), p_(p) {}

  ClosestReport run() {
    search(scene_.structure_.world(), nullptr, -1);
    ClosestReport report;
    if (best_.shape < 0) return report;
    const V3d way = found_ - p_;
    const double distance = way.length();
    const V3d d = distance > 0 ? way / distance : V3d(0, 0, 1);
    best_.t = distance;
    std::vector<SurfaceHit> hits;
    scene_.describe({{p_.x, p_.y, p_.z}, {d.x, d.y, d.z}}, {best_}, hits);
    report.hit = hits[0];
    report.hit->p = found_ + scene_.parts_.origin;
    report.hit->from_front = hits[0].normal.dot(way) <= 0;
    report.error = std::max(distance - unknown_, 0.0);
    return report;
  }

 private:
  /// An instance: its map, and what it leaves of a distance at least.
  struct Placed {
    ExactAffine place;
    double least;
  };

  void search(const Level<Bvh>& level, const Placed* placed, std::int32_t instance) {
    if (level.primitives.empty()) return;
    const V3d own = placed != nullptr ? apply(inverse(placed->place), p_) : p_;
    const double scale = placed != nullptr ? placed->least : 1;
    visit(level, placed, instance, own, scale, 0);
  }

  // Recurses as deep as the tree goes: kBvhDepth levels at most.
  void visit(const Level<Bvh>& level, const Placed* placed, std::int32_t instance, const V3d& own,
             double scale, std::int32_t at) {
    const BvhNode& node = level.tree.nodes[static_cast<std::size_t>(at)];
    double away[2];
    for (int c = 0; c < 2; ++c) {
      Box box;
      for (int k = 0; k < 3; ++k) box.low[k] = node.planes[k][c], box.high[k] = node.planes[k][2 + c];
      away[c] = distance_to(box, own) * scale;
    }
    const int nearer = away[1] < away[0];
    for (const int c : {nearer, 1 - nearer}) {
      if (!(away[c] <= distance_)) continue;
      if (node.child[c] >= 0) visit(level, placed, instance, own, scale, node.child[c]);
      for (std::int32_t i = 0; node.child[c] < 0 && i < node.count[c]; ++i)
        meet(level.primitives[static_cast<std::size_t>(~node.child[c] + i)], placed, instance, own, scale);
    }
  }

  void meet(const Primitive& primitive, const Placed* placed, std::int32_t instance, const V3d& own,
            double scale) {
    const double away = distance_to(box_of(primitive), own) * scale;
    if (!(away <= distance_)) return;
    switch (primitive.kind) {
      case PrimitiveKind::kTriangle: {
        V3d corner[3];
        for (int c = 0; c < 3; ++c) {
          corner[c] = to_point(primitive.corners[c]);
          if (placed != nullptr) corner[c] = apply(placed->place, corner[c]);
        }
        const TrianglePoint q = nearest_on_triangle(p_, corner[0], corner[1], corner[2]);
        take(q.p, {0, q.b1, q.b2, primitive.shape, primitive.number, instance});
        break;
      }
      case PrimitiveKind::kAnalytic:
        meet_analytic(primitive, placed, instance, away);
        break;
      case PrimitiveKind::kInstance: {
        const ExactAffine place =
            scene_.structure_.render_from_instance(primitive.number, scene_.parts_.time);
        const Placed inner{place, least_scale(place)};
        const std::int32_t object =
            scene_.table().instances[static_cast<std::size_t>(primitive.number)].object;
        search(scene_.structure_.object(object), &inner, primitive.number);
        break;
      }
      case PrimitiveKind::kDeforming:
        assert(!"queries are asked of one moment");
        break;
    }
  }

  void meet_analytic(const Primitive& primitive, const Placed* placed, std::int32_t instance, double away) {
    const ShapeTable& table = scene_.table();
    const ShapeRecord& shape = scene_.record(primitive.shape);
    ExactAffine place = placed_from_object(table, shape);
    if (placed != nullptr) place = compose(placed->place, place);
    const Crossing crossing{0, 0, 0, primitive.shape, primitive.number, instance};
    const std::vector<Face>& faces = scene_.faces_[static_cast<std::size_t>(primitive.shape)];
    for (const Face& face : faces) {
      corners_.clear();
      for (const V3d& corner : face) corners_.push_back(apply(place, corner));
      take(nearest_on_polygon(p_, corners_), crossing);
    }
    if (!faces.empty()) return;
    if (const auto q = nearest_on_round(p_, place, table, shape, *scene_.parts_.kernel)) {
      take(*q, crossing);
    } else if (has_formula(table, shape, *scene_.parts_.kernel, place)) {
      take(nearest_on_ellipsoid(p_, place, table.quadrics[static_cast<std::size_t>(shape.quadric)].radius),
           crossing);
    } else {
      unknown_ = std::min(unknown_, away);
    }
  }

  void take(const V3d& q, const Crossing& where) {
    const double distance = (q - p_).length();
    if (!(distance < distance_)) return;
    distance_ = distance, found_ = q, best_ = where;
  }

  const QueryScene& scene_;
  const V3d p_;
  double distance_ = HUGE_VAL, unknown_ = HUGE_VAL;
  V3d found_{0, 0, 0};
  Crossing best_;
  std::vector<V3d> corners_;
};

ClosestReport QueryScene::closest(const V3d& p) const {
  return ClosestSearch(*this, p - parts_.origin).run();
}

std::vector<std::int32_t> QueryScene::without_closest() const {
  std::vector<std::int32_t> shapes;
  const std::span<const ShapeRecord> placed = table().placed();
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const ShapeRecord& shape = placed[i];
    if (shape.kind != ShapeKind::kCurves &&
        !has_formula(table(), shape, *parts_.kernel, placed_from_object(table(), shape)))
      shapes.push_back(static_cast<std::int32_t>(i));
  }
  return shapes;
}

}  // namespace tessera::render
