#include "render/accel/structure/structure_query.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <tuple>

#include "render/accel/structure/meet.h"
#include "render/accel/structure/structure_list.h"
#include "render/shape/analytic_shape.h"
#include "render/shape/implicit/mark_cells.h"
#include "render/shape/place.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// The way down to a primitive, by its number in the list of each level.
struct Way {
  static constexpr int kMostLevels = 4;  // longer ways are not kept
  std::uint32_t steps[kMostLevels];
  int length = 0;  // 0: there is none
};

/// Nearest hit that a ray has met so far; of those that are equally near the one with the least numbers, so
/// that the order of a walk does not matter. Where any hit will do, `t` stays.
struct Found {
  float t;
  float u = 0, v = 0;
  std::int32_t shape = -1, primitive = -1;
  std::int64_t place = -1;
  Way* way = nullptr;  // set where any hit will do, if wanted: to what was hit

  bool gives_way_to(const Meeting& other, const Primitive& p, std::int64_t at_place) const {
    if (other.t != t) return other.t < t;
    return shape < 0 || std::tuple(p.shape, p.number, at_place) < std::tuple(shape, primitive, place);
  }
};

/// Visitor to which a walk shows primitives (brute_walk.h): one ray in the space of one level.
template <class Tree, bool kAny>
struct Tracer {
  static constexpr bool kAnyHit = kAny;
  const TreeStructure<Tree>& structure;
  const Level<Tree>& level;
  const Ray& ray;
  const std::int64_t place;  // of the level's object; without objects in objects the instance; -1: the world
  Found& found;
  RayVisits& visits;
  const int depth = 0;  // of the level: 0 is the world
  // Instances that have been walked, by their numbers' last bits: in several cells, they would be again, and
  // so would be what they hold, and so on [AmanatidesWoo1987].
  std::int32_t walked[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

  float reach() const { return found.t; }
  void enter() { ++visits.nodes; }

  void run() {
    if (!level.primitives.empty()) walk(level.tree, level.box, ray, *this);
  }

  /// Meets the primitive at the end of the way, and nothing else.
  bool meet_end_of(const Way& way) {
    const std::uint32_t i = way.steps[depth];
    if (depth + 1 == way.length) return meet(i);
    return within_instance(level.primitives[i], [&way](auto& inner) { return inner.meet_end_of(way); });
  }

  TESSERA_INLINE bool meet(std::uint32_t i) {
    const Primitive& primitive = level.primitives[i];
    ++visits.primitives;
    Meeting meeting;
    if (primitive.kind == PrimitiveKind::kTriangle) {
      if (!meet_triangle(ray, primitive.corners, meeting) || meeting.t > found.t) return false;
    } else if (primitive.kind == PrimitiveKind::kInstance) {
      const auto walk_it = [](auto& inner) { return inner.run(), kAny && inner.found.shape >= 0; };
      if (!within_instance(primitive, walk_it)) return false;
      note_step(primitive);
      return true;
    } else if (primitive.kind == PrimitiveKind::kDeforming) {
      if (!meet_deforming(ray, structure.shapes(), primitive, meeting) || meeting.t > found.t) return false;
    } else if (!meet_analytic(ray, structure.shapes(), structure.textures(), primitive, found.t, meeting)) {
      return false;
    }
    return take(primitive, meeting);
  }

  /// A triangle whose corners stand elsewhere, too.
  TESSERA_INLINE bool meet_corners(const float (&corners)[3][3], std::uint32_t i) {
    ++visits.primitives;
    Meeting meeting;
    if (!meet_triangle(ray, corners, meeting) || meeting.t > found.t) return false;
    return take(level.primitives[i], meeting);
  }

  TESSERA_INLINE bool take(const Primitive& primitive, const Meeting& meeting) {
    if (!found.gives_way_to(meeting, primitive, place)) return false;
    if (primitive.has_alpha &&
        passes_through(ray, structure.shapes(), structure.textures(), primitive, meeting))
      return false;
    if (!kAny) found.t = meeting.t;
    found.u = meeting.u, found.v = meeting.v;
    found.shape = primitive.shape, found.primitive = primitive.number, found.place = place;
    if (!kAny) return false;
    if (found.way != nullptr) found.way->length = depth + 1 <= Way::kMostLevels ? depth + 1 : 0;
    note_step(primitive);
    return true;
  }

  /// The way to what was hit leads over this primitive.
  void note_step(const Primitive& primitive) {
    if (found.way == nullptr || depth >= Way::kMostLevels) return;
    found.way->steps[depth] = static_cast<std::uint32_t>(&primitive - level.primitives.data());
  }

  /// Returns what `ask` says of a tracer in the space of the object that an instance places; false where the
  /// ray passes it, or has been there.
  template <class Ask>
  bool within_instance(const Primitive& primitive, Ask&& ask) {
    const Ray::Interval box = ray.within(primitive.corners[0], primitive.corners[1]);
    if (box.empty() || box.enter > found.t) return false;
    std::int32_t& last = walked[primitive.number % 16];
    if (last == primitive.number) return false;
    last = primitive.number;
    const ShapeTable& shapes = structure.shapes();
    const bool in_world = place < 0;
    const InstanceRecord& record =
        (in_world ? shapes.instances : shapes.inner)[static_cast<std::size_t>(primitive.number)];
    const Level<Tree>& object = structure.object(record.object);
    const ExactAffine to_object = record.segments != 0 ? inverse(placement_at(shapes, record, ray.time))
                                  : in_world           ? structure.instance_from_render(primitive.number)
                                                       : structure.inner_from_holder(primitive.number);
    const Ray own = moved(ray, to_object, object.largest);
    if (!own.sound()) return false;  // the instance has no extent
    const std::int64_t own_place = !shapes.nested() ? primitive.number
                                   : in_world       ? record.first_place
                                                    : place_within(place, record);
    Tracer<Tree, kAny> inner{structure, object, own, own_place, found, visits, depth + 1};
    return ask(inner);
  }
};

/// Remembers what blocked the last shadow rays of this thread, by where they end: rays to one light are
/// blocked by one thing again and again [Haines & Greenberg 1986].
struct ShadowCache {
  static constexpr std::size_t kEnds = 64;
  std::uint64_t query = 0;  // whose primitives the ways lead to
  Way ways[kEnds];

  static ShadowCache& of(std::uint64_t query) {
    static thread_local ShadowCache cache;
    if (cache.query != query) cache = {.query = query, .ways = {}};
    return cache;
  }
  /// `cell`: the size of places that share an occluder.
  Way& at_end_of(const Ray& ray, float distance, float cell) {
    // Of light from infinity the direction.
    const bool ends = distance < 1e6f * cell;
    std::uint32_t hash = 0;
    for (int k = 0; k < 3; ++k) {
      const double x = ends ? (ray.o[k] + distance * ray.d[k]) / cell : 4 * ray.d[k];
      const auto at = static_cast<std::int32_t>(std::floor(std::clamp(x, -1e9, 1e9)));
      hash = (hash ^ static_cast<std::uint32_t>(at)) * 0x9e3779b1u;
    }
    return ways[hash >> 26];
  }
};
static_assert(ShadowCache::kEnds == std::size_t{1} << (32 - 26));

/// Queries are told apart by numbers: another may come to lie where one was.
std::uint64_t next_query() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

/// Coordinates up to Embree's limit.
bool is_sound(const RayArrays& rays, int i) {
  constexpr float kFarthest = 1.8e18f;
  bool somewhere = false;
  for (const float* x : {rays.ox, rays.oy, rays.oz, rays.dx, rays.dy, rays.dz}) {
    if (!(std::abs(x[i]) <= kFarthest)) return false;
  }
  for (const float* x : {rays.dx, rays.dy, rays.dz}) somewhere = somewhere || x[i] != 0;
  return somewhere;
}

template <class Tree>
class StructureQuery final : public RayQuery {
 public:
  explicit StructureQuery(const TreeStructure<Tree>& structure)
      : structure_(structure),
        number_(next_query()),
        cell_(std::max(structure.bounding_radius() / 8, std::numeric_limits<float>::min())) {}

  void nearest(const RayArrays& rays, int n, bool, const HitArrays& hits) const override {
    RayVisits all;
    for (int i = 0; i < n; ++i) {
      RayVisits visits;
      const Found found = trace(rays, i, visits);
      hits.t[i] = found.t, hits.u[i] = found.u, hits.v[i] = found.v;
      hits.primitive[i] = found.primitive, hits.shape[i] = found.shape;
      hits.instance[i] = found.place < 0 ? -1 : lower_part(found.place);
      if (hits.upper != nullptr && structure_.shapes().nested())
        hits.upper[i] = found.place < 0 ? 0 : upper_part(found.place);
      if (hits.visited_nodes != nullptr) {
        hits.visited_nodes[i] = static_cast<std::int32_t>(visits.nodes);
        hits.visited_primitives[i] = static_cast<std::int32_t>(visits.primitives);
      }
      all += visits;
    }
    add(all);
  }

  void occluded(const RayArrays& rays, int n, float* distance_in_blocked_out) const override {
    RayVisits all;
    for (int i = 0; i < n; ++i) {
      float& distance = distance_in_blocked_out[i];
      if (distance < 0) continue;
      if (is_blocked(rays, i, distance, all)) distance = -__builtin_inff();
    }
    add(all);
  }

  RayVisits visits() const override { return {nodes_, primitives_}; }

 private:
  Ray ray_of(const RayArrays& rays, int i) const {
    const double o[3] = {rays.ox[i], rays.oy[i], rays.oz[i]}, d[3] = {rays.dx[i], rays.dy[i], rays.dz[i]};
    return {o, d, rays.time != nullptr ? rays.time[i] : 0, structure_.world().largest};
  }

  template <bool kAny>
  Tracer<Tree, kAny> tracer(const Ray& ray, Found& found, RayVisits& visits) const {
    return {structure_, structure_.world(), ray, -1, found, visits};
  }

  Found trace(const RayArrays& rays, int i, RayVisits& visits) const {
    Found found{.t = __builtin_inff()};
    if (is_sound(rays, i)) tracer<false>(ray_of(rays, i), found, visits).run();
    return found;
  }

  bool is_blocked(const RayArrays& rays, int i, float distance, RayVisits& visits) const {
    if (!is_sound(rays, i)) return true;
    const Ray ray = ray_of(rays, i);
    Found found{.t = distance};
    if (structure_.has_shadow_cache()) {
      Way& last = ShadowCache::of(number_).at_end_of(ray, distance, cell_);
      // The walk would meet the blocker, too: only the order is another.
      if (last.length > 0 && tracer<true>(ray, found, visits).meet_end_of(last)) return true;
      found.way = &last;
    }
    tracer<true>(ray, found, visits).run();
    return found.shape >= 0;
  }

  void add(const RayVisits& visits) const {
    nodes_.fetch_add(visits.nodes, std::memory_order_relaxed);
    primitives_.fetch_add(visits.primitives, std::memory_order_relaxed);
  }

  const TreeStructure<Tree>& structure_;
  const std::uint64_t number_;
  const float cell_;  // of the shadow cache
  mutable std::atomic<std::uint64_t> nodes_{0}, primitives_{0};
};

template <class Tree>
std::unique_ptr<RayQuery> query_of(const SceneStructure& structure) {
  return std::make_unique<StructureQuery<Tree>>(static_cast<const TreeStructure<Tree>&>(structure));
}

std::unique_ptr<RayQuery> make_structure_query(const SceneStructure& structure) {
  std::unique_ptr<RayQuery> query;
  with_structure(structure.kind(),
                 [&]<class Row>(const Row&) { query = query_of<typename Row::Tree>(structure); });
  return query;
}

std::int32_t count_analytic(const ShapeTable& table, std::int32_t shape) {
  const ShapeRecord& record = table.shapes[static_cast<std::size_t>(shape)];
  return analytic_shape(record.kind)->primitive_count(table, record);
}

Box bounds_of_analytic(const ShapeTable& table, std::int32_t shape, std::int32_t primitive) {
  const ShapeRecord& record = table.shapes[static_cast<std::size_t>(shape)];
  const ShapeBounds bounds = analytic_shape(record.kind)->bounds(table, record, primitive);
  Box box;
  std::copy_n(bounds.low, 3, box.low);
  std::copy_n(bounds.high, 3, box.high);
  return box;
}

void prepare_shapes(ShapeTable& shapes) {
  // Many surfaces share what one may take eight times.
  constexpr std::size_t kMost = std::size_t{1} << 21, kAll = 8 * kMost;
  const std::size_t most_work = std::min(kMost, kAll / std::max<std::size_t>(shapes.implicits.size(), 1));
  for (ImplicitRecord& surface : shapes.implicits) mark_cells(surface, most_work);
}

}  // namespace

const StructureKernel& structure_kernel() {
  static constexpr StructureKernel kKernel{
      {&count_analytic, &bounds_of_analytic}, &prepare_shapes, &make_structure_query};
  return kKernel;
}

}  // namespace tessera::render::TESSERA_ISA
