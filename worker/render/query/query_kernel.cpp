#include "render/query/query_kernel.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include "render/accel/bvh/bvh_walk.h"
#include "render/query/cross_triangle.h"
#include "render/query/query_entry.h"
#include "render/shape/analytic_shape.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A walk's visitor (accel/brute/brute_walk.h) that wants everything: one ray in the space of one level.
struct Collector {
  const QueryStructure& structure;
  const Level<Bvh>& level;
  const Ray& ray;
  const std::int32_t instance;
  std::vector<Crossing>& found;
  std::vector<double>& roots;  // room for those of one shape

  float reach() const { return __builtin_inff(); }
  void enter() {}

  void run() {
    if (!level.primitives.empty()) walk_pairs(level.tree, ray, *this);
  }

  bool meet(std::uint32_t i) {
    const Primitive& primitive = level.primitives[i];
    switch (primitive.kind) {
      case PrimitiveKind::kTriangle: {
        TriangleCrossing at;
        if (cross_triangle(ray, primitive.corners, at))
          found.push_back({at.t, at.b1, at.b2, primitive.shape, primitive.number, instance,
                           static_cast<std::int8_t>(at.against ? 1 : -1)});
        break;
      }
      case PrimitiveKind::kAnalytic:
        meet_analytic(primitive);
        break;
      case PrimitiveKind::kInstance:
        meet_instance(primitive);
        break;
      case PrimitiveKind::kDeforming:
        assert(!"queries are asked of one moment");
        break;
    }
    return false;
  }

  void meet_analytic(const Primitive& primitive) {
    if (ray.within(primitive.corners[0], primitive.corners[1]).empty()) return;
    const ShapeTable& table = structure.shapes();
    const ShapeRecord& shape = table.shapes[static_cast<std::size_t>(primitive.shape)];
    const ExactRay line{{ray.o[0], ray.o[1], ray.o[2]}, {ray.d[0], ray.d[1], ray.d[2]}};
    roots.clear();
    analytic_shape(shape.kind)->crossings(table, shape, primitive.number, line, roots);
    for (const double t : roots) {
      if (t > 0) found.push_back({t, 0, 0, primitive.shape, primitive.number, instance});
    }
  }

  void meet_instance(const Primitive& primitive) {
    if (ray.within(primitive.corners[0], primitive.corners[1]).empty()) return;
    const Level<Bvh>& object =
        structure.object(structure.shapes().instances[static_cast<std::size_t>(primitive.number)].object);
    const Ray own = moved(ray, structure.instance_from_render(primitive.number, ray.time), object.largest);
    if (own.sound()) Collector{structure, object, own, primitive.number, found, roots}.run();
  }
};

void find_crossings(const QueryStructure& structure, const ExactRay& line, float time,
                    std::vector<Crossing>& found) {
  found.clear();
  std::vector<double> roots;
  const Ray ray(line.o, line.d, time, structure.world().largest);
  Collector{structure, structure.world(), ray, -1, found, roots}.run();
  std::ranges::sort(found, {},
                    [](const Crossing& c) { return std::tie(c.t, c.instance, c.shape, c.primitive); });
}

/// Sixteen or fewer.
void describe_some(const ShapeTable& table, std::span<const ExactRay* const> rays, float time,
                   std::span<const Crossing> crossings, SurfacePoint* points) {
  alignas(64) float o[3][kWidth] = {}, d[3][kWidth], t[kWidth] = {}, b1[kWidth] = {}, b2[kWidth] = {};
  alignas(64) std::int32_t shape[kWidth] = {}, primitive[kWidth] = {}, instance[kWidth] = {};
  for (std::size_t i = 0; i < kWidth; ++i) {
    const ExactRay& ray = *rays[std::min(i, rays.size() - 1)];
    const double length = std::hypot(ray.d[0], ray.d[1], ray.d[2]);
    for (int k = 0; k < 3; ++k) d[k][i] = static_cast<float>(ray.d[k] / length);
    if (i >= crossings.size()) continue;
    const Crossing& c = crossings[i];
    // The ray is followed from no farther away than the point is from the origin: floats are as fine there.
    double size = 0;
    for (int k = 0; k < 3; ++k) size = std::max(size, std::abs(ray.at(k, c.t)));
    const double back = std::min(c.t, size / length);
    for (int k = 0; k < 3; ++k) o[k][i] = static_cast<float>(ray.at(k, c.t - back));
    t[i] = static_cast<float>(back * length);
    b1[i] = static_cast<float>(c.b1), b2[i] = static_cast<float>(c.b2);
    shape[i] = c.shape, primitive[i] = c.primitive, instance[i] = c.instance;
  }
  const Hit hit{Float::load(t),   Float::load(b1),     Float::load(b2), Int::load(primitive),
                Int::load(shape), Int::load(instance), Float(time)};
  const Surface s = surface_at(table, hit, {Float::load(o[0]), Float::load(o[1]), Float::load(o[2])},
                               {Float::load(d[0]), Float::load(d[1]), Float::load(d[2])},
                               Mask::first(static_cast<int>(crossings.size())), false);
  alignas(64) float lanes[5][kWidth];
  const Float values[5] = {s.ng.x, s.ng.y, s.ng.z, s.uv.x, s.uv.y};
  for (int k = 0; k < 5; ++k) values[k].store(lanes[k]);
  for (std::size_t i = 0; i < crossings.size(); ++i)
    points[i] = {{lanes[0][i], lanes[1][i], lanes[2][i]}, {lanes[3][i], lanes[4][i]}};
}

void describe(const ShapeTable& table, std::span<const ExactRay* const> rays, float time,
              std::span<const Crossing> crossings, std::span<SurfacePoint> points) {
  for (std::size_t i = 0; i < crossings.size(); i += kWidth) {
    const std::size_t count = std::min<std::size_t>(kWidth, crossings.size() - i);
    describe_some(table, rays.subspan(i, count), time, crossings.subspan(i, count), points.data() + i);
  }
}

const RoundForm* round_form(ShapeKind kind) {
  const AnalyticShape* const model = analytic_shape(kind);
  return model == nullptr ? nullptr : model->round_form();
}

}  // namespace

const QueryKernel& query_kernel() {
  static constexpr QueryKernel kKernel{&find_crossings, &describe, &implicit_value, &round_form};
  return kKernel;
}

}  // namespace tessera::render::TESSERA_ISA
