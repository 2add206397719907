#include "render/transport/vertex/first_hits.h"

#include <bit>

#include "render/film/summable.h"
#include "render/sensor/sensor.h"
#include "render/shape/key_vertices.h"
#include "render/shape/place.h"

namespace tessera::render::TESSERA_ISA {

using wire::ChannelKind;
using wire::HitAov;

namespace {

struct Point {
  double x[3];
};

Point moved(const ExactAffine& map, const Point& p) {
  Point result;
  for (int i = 0; i < 3; ++i) {
    const double* const row = map.m + 4 * i;
    result.x[i] = row[0] * p.x[0] + row[1] * p.x[1] + row[2] * p.x[2] + row[3];
  }
  return result;
}

/// A point of a shape's surface, which is at `local` at the time `now`, in the shape's own space at `time`.
/// `u`, `v`: parameters of its hit.
Point deformed(const ShapeTable& table, const ShapeRecord& shape, std::int32_t primitive, float u, float v,
               const Point& local, float now, float time) {
  if ((shape.flags & kDeforms) == 0) return local;
  Point place = local;
  if (shape.kind == ShapeKind::kTriangles) {
    float corners[3][3];
    corners_at(table, shape, primitive, time, corners);
    for (int k = 0; k < 3; ++k)
      place.x[k] = (1.0 - u - v) * corners[0][k] + double{u} * corners[1][k] + double{v} * corners[2][k];
    return place;
  }
  // Across a strand it stays where it is.
  double axis[3], axis_now[3];
  const CurvesRecord& curves = table.curves[static_cast<std::size_t>(shape.quadric)];
  axis_at(curves, primitive, u, time, axis), axis_at(curves, primitive, u, now, axis_now);
  for (int k = 0; k < 3; ++k) place.x[k] += axis[k] - axis_now[k];
  return place;
}

}  // namespace

std::size_t FirstHits::planes() const {
  int planes = 0;
  for (const wire::HitAovRow& row : first_hit_rows()) {
    const int own = row.kind == ChannelKind::kEntry ? 2 : row.channel_count();
    planes += scene_.aovs.has(row.aov) ? own : 0;
  }
  return static_cast<std::size_t>(planes);
}

void FirstHits::clear(int slot) {
  for (float* const lanes : values_) Float(0.0f).store(lanes + slot);
  Float(0.0f).store(time_ + slot);
}

void FirstHits::record(const Vertex& v, Int slot, Mask hit) {
  keep(HitAov::kPosition, slot, hit, v.surface.p.x, v.surface.p.y, v.surface.p.z);
  if (scene_.any_motion) scatter(v.time, time_, slot, hit);
  const Mask on_surface = and_not(hit, v.in_medium);
  if (scene_.aovs.has(HitAov::kCameraNormal)) {
    const Float time = scene_.any_motion ? v.time : Float(0.0f);
    const Vec3 normal = normal_in_sensor(scene_.sensor, face_forward(v.at.frame.z, v.wo), time);
    keep(HitAov::kCameraNormal, slot, on_surface, normal.x, normal.y, normal.z);
  }
  if (scene_.aovs.has(HitAov::kUv)) keep(HitAov::kUv, slot, on_surface, v.surface.uv.x, v.surface.uv.y);
}

void FirstHits::record_hit(const Hit& found, Float shape, Float instance, Int slot, Mask hit) {
  const Float material =
      to_float(gather_member(scene_.shapes.shapes.data(), &ShapeRecord::material, found.shape, hit)) + 1.0f;
  keep(HitAov::kMaterialId, slot, hit, material);
  keep(HitAov::kCryptoObject, slot, hit, shape);
  keep(HitAov::kCryptoMaterial, slot, hit, material);
  // A shape that nothing places is told apart from instances by its sign.
  keep(HitAov::kCryptoAsset, slot, hit, select(instance > 0.0f, instance, -shape));
  if (scene_.aovs.has(HitAov::kMotion) && scene_.any_motion) record_motion(found, slot, hit);
}

void FirstHits::record_motion(const Hit& found, Int slot, Mask hit) {
  const ShapeTable& table = scene_.shapes;
  alignas(64) std::int32_t instance[kWidth], upper[kWidth], at[kWidth], shape[kWidth], primitive[kWidth];
  alignas(64) float u[kWidth], v[kWidth];
  found.instance.store(instance), found.upper.store(upper), slot.store(at);
  found.shape.store(shape), found.primitive.store(primitive), found.u.store(u), found.v.store(v);
  Vec3 open{Float(0.0f), Float(0.0f), Float(0.0f)}, closed = open;
  alignas(64) float places[2][3][kWidth] = {};
  for (std::uint32_t bits = hit.bits(); bits != 0; bits &= bits - 1) {
    const int lane = std::countr_zero(bits);
    const int sample = at[lane];
    const Point p{{values_[0][sample], values_[1][sample], values_[2][sample]}};
    const auto map_at = [&](float time) -> ExactAffine {
      if (instance[lane] < 0) return {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
      if (table.nested())
        return map_of_place(table, place_number(instance[lane], upper[lane]), time).render_from_object;
      return placement_at(table, table.instances[static_cast<std::size_t>(instance[lane])], time);
    };
    const Point local = moved(inverse(map_at(time_[sample])), p);
    for (int end = 0; end < 2; ++end) {
      const auto time = static_cast<float>(end);
      const Point there = deformed(table, table.shapes[static_cast<std::size_t>(shape[lane])],
                                   primitive[lane], u[lane], v[lane], local, time_[sample], time);
      const Point place = moved(map_at(time), there);
      for (int i = 0; i < 3; ++i) places[end][i][lane] = static_cast<float>(place.x[i]);
    }
  }
  open = {Float::load(places[0][0]), Float::load(places[0][1]), Float::load(places[0][2])};
  closed = {Float::load(places[1][0]), Float::load(places[1][1]), Float::load(places[1][2])};
  const Vec2 middle{Float(0.5f), Float(0.5f)};
  const SensorConnection from = connect_to_sensor(scene_.sensor, open, middle, Float(0.0f), hit);
  const SensorConnection to = connect_to_sensor(scene_.sensor, closed, middle, Float(1.0f), hit);
  const Mask seen = hit & from.valid & to.valid;
  keep(HitAov::kMotion, slot, seen, to.raster.x - from.raster.x, to.raster.y - from.raster.y);
}

float* FirstHits::put(int slot, Float weight, Mask covered, float* to, std::size_t stride) const {
  const auto put_raw = [&](Float value) {
    value.store_unaligned(to);
    to += stride;
  };
  int next = 0;
  for (const wire::HitAovRow& row : first_hit_rows()) {
    const int first = next;
    next += row.channel_count();
    if (!scene_.aovs.has(row.aov)) continue;
    for (int i = 0; i < row.channel_count(); ++i) {
      Float value = Float::load(values_[first + i] + slot);
      if (row.aov == HitAov::kPosition) value = select_or_zero(covered, value + scene_.render_origin[i]);
      if (row.kind == ChannelKind::kSum) value = select_or_zero(is_summable(value), value) * weight;
      put_raw(value);
      if (row.kind == ChannelKind::kEntry) put_raw(select_or_zero(value != 0.0f, weight));
    }
  }
  return to;
}

}  // namespace tessera::render::TESSERA_ISA
