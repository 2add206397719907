#include "render/query/query_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/query/containment.h"

namespace tessera::render {

QueryScene::QueryScene(Parts parts) : parts_(std::move(parts)) {}
QueryScene::~QueryScene() = default;

absl::StatusOr<std::unique_ptr<const QueryScene>> QueryScene::build(Parts parts) {
  std::unique_ptr<QueryScene> self(new QueryScene(std::move(parts)));
  absl::StatusOr<QueryStructure> structure =
      QueryStructure::build(self->table(), self->parts_.analytic, self->parts_.threads);
  if (!structure.ok()) return structure.status();
  self->structure_ = *std::move(structure);
  const std::size_t count = self->table().shapes.size();
  self->faces_.reserve(count);
  for (const ShapeRecord& shape : self->table().shapes) {
    self->faces_.push_back(plane_faces(self->table(), shape));
    self->mesh_facts_.push_back(shape.kind == ShapeKind::kTriangles ? std::make_unique<MeshFacts>()
                                                                    : nullptr);
  }
  self->build_boxes();
  for (std::int32_t i = 0; i < self->table().world_shape_count; ++i) {
    if (is_unbounded(self->record(i))) self->half_spaces_.push_back(i);
  }
  for (std::size_t i = 0; i < self->table().instances.size(); ++i) {
    if (is_unbounded(self->table(), self->table().instances[i]))
      self->half_space_instances_.push_back(static_cast<std::int32_t>(i));
  }
  self->far_medium_ = self->medium_far_away();
  return self;
}

std::int32_t QueryScene::instance_number(std::int32_t instance) const {
  return instance < 0 ? 0 : table().instances[static_cast<std::size_t>(instance)].number;
}

void QueryScene::build_boxes() {
  const auto boxes_of = [&](const std::vector<Primitive>& primitives, std::int32_t first,
                            std::int32_t count) {
    std::vector<Box> boxes(static_cast<std::size_t>(count));
    for (const Primitive& primitive : primitives) {
      if (primitive.kind != PrimitiveKind::kInstance)
        boxes[static_cast<std::size_t>(primitive.shape - first)].add(box_of(primitive));
    }
    std::vector<Primitive> list;
    for (std::int32_t i = 0; i < count; ++i) {
      const Box& box = boxes[static_cast<std::size_t>(i)];
      if (box.empty()) continue;
      Primitive primitive{};
      primitive.kind = PrimitiveKind::kAnalytic;
      primitive.shape = first + i;
      std::copy_n(box.low, 3, primitive.corners[0]);
      std::copy_n(box.high, 3, primitive.corners[1]);
      list.push_back(primitive);
    }
    return list;
  };
  for (std::size_t i = 0; i < table().objects.size(); ++i) {
    const ObjectRange& range = table().objects[i];
    boxes_of_objects_.push_back(boxes_of(structure_.object(static_cast<std::int32_t>(i)).primitives,
                                         range.first_shape, range.shape_count));
  }
  const std::vector<Primitive>& world = structure_.world().primitives;
  shape_boxes_.primitives = boxes_of(world, 0, table().world_shape_count);
  std::ranges::copy_if(world, std::back_inserter(shape_boxes_.primitives),
                       [](const Primitive& p) { return p.kind == PrimitiveKind::kInstance; });
  shape_boxes_.tree = build_bvh(BvhRule::kMedian, shape_boxes_.primitives, parts_.threads);
}

std::vector<std::int32_t> QueryScene::left_out() const {
  std::vector<std::int32_t> curves;
  for (std::size_t i = 0; i < table().shapes.size(); ++i) {
    if (table().shapes[i].kind == ShapeKind::kCurves) curves.push_back(static_cast<std::int32_t>(i));
  }
  return curves;
}

void QueryScene::describe(const ExactRay& ray, const std::vector<Crossing>& crossings,
                          std::vector<SurfaceHit>& hits) const {
  hits.resize(crossings.size());
  describe_all(std::vector<const ExactRay*>(crossings.size(), &ray), crossings, hits);
}

void QueryScene::describe_all(std::span<const ExactRay* const> rays, std::span<const Crossing> crossings,
                              std::span<SurfaceHit> hits) const {
  std::vector<SurfacePoint> points(crossings.size());
  parts_.kernel->describe(table(), rays, parts_.time, crossings, points);
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const Crossing& c = crossings[i];
    const ExactRay& ray = *rays[i];
    SurfaceHit& hit = hits[i];
    hit.t = c.t;
    hit.p = V3d(ray.at(0, c.t), ray.at(1, c.t), ray.at(2, c.t)) + parts_.origin;
    hit.normal = to_point(points[i].normal);
    hit.u = points[i].uv[0], hit.v = points[i].uv[1];
    hit.from_front = c.against != 0 ? c.against > 0 : hit.normal.dot(V3d(ray.d[0], ray.d[1], ray.d[2])) < 0;
    hit.shape = c.shape, hit.primitive = c.primitive, hit.instance = c.instance;
  }
}

std::vector<SurfaceHit> QueryScene::hits(const V3d& origin, const V3d& direction) const {
  const Line line{origin, direction};
  return std::move(hits({&line, 1}).front());
}

std::vector<std::vector<SurfaceHit>> QueryScene::hits(std::span<const Line> lines) const {
  std::vector<ExactRay> rays;
  std::vector<int> exponents;
  rays.reserve(lines.size()), exponents.reserve(lines.size());
  std::vector<Crossing> found, crossings;
  std::vector<const ExactRay*> ray_of;
  std::vector<std::size_t> ends;
  for (const auto& [origin, direction] : lines) {
    const V3d o = origin - parts_.origin;
    // Brought to about unit length, by a power of two: what is not in double precision has floats' range.
    const int exponent =
        std::ilogb(std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)}));
    const auto scaled = [&](double x) { return std::scalbn(x, -exponent); };
    rays.push_back({{o.x, o.y, o.z}, {scaled(direction.x), scaled(direction.y), scaled(direction.z)}});
    exponents.push_back(exponent);
    parts_.kernel->find_crossings(structure_, rays.back(), parts_.time, found);
    crossings.insert(crossings.end(), found.begin(), found.end());
    ray_of.resize(crossings.size(), &rays.back());
    ends.push_back(crossings.size());
  }
  std::vector<SurfaceHit> all(crossings.size());
  describe_all(ray_of, crossings, all);
  std::vector<std::vector<SurfaceHit>> hits;
  hits.reserve(lines.size());
  auto next = all.begin();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto end = all.begin() + static_cast<std::ptrdiff_t>(ends[i]);
    std::vector<SurfaceHit>& own = hits.emplace_back(next, end);
    for (SurfaceHit& hit : own) hit.t = std::scalbn(hit.t, -exponents[i]);
    next = end;
  }
  return hits;
}

}  // namespace tessera::render
