#include "render/transport/vertex/first_hits.h"

#include <bit>

#include "render/film/summable.h"
#include "render/sensor/sensor.h"
#include "render/shape/place.h"

namespace tessera::render::TESSERA_ISA {

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

}  // namespace

std::size_t FirstHits::planes() const {
  const AovRequest& aovs = scene_.aovs;
  const int lists = aovs.crypto_object + aovs.crypto_material + aovs.crypto_asset;
  return static_cast<std::size_t>(3 * aovs.position + 3 * aovs.camera_normal + 2 * aovs.uv + 2 * aovs.motion +
                                  aovs.material_id + 2 * lists);
}

void FirstHits::clear(int slot) {
  const Float zero(0.0f);
  store_lanes(Vec3{zero, zero, zero}, position_, slot);
  store_lanes(Vec3{zero, zero, zero}, camera_normal_, slot);
  for (float* const lanes : {u_, v_, motion_u_, motion_v_, time_, shape_, material_, asset_})
    zero.store(lanes + slot);
}

void FirstHits::record(const Vertex& v, Int slot, Mask hit) {
  scatter_lanes(v.surface.p, position_, slot, hit);
  if (scene_.any_motion) scatter(v.time, time_, slot, hit);
  const Mask on_surface = and_not(hit, v.in_medium);
  if (scene_.aovs.camera_normal) {
    const Float time = scene_.any_motion ? v.time : Float(0.0f);
    scatter_lanes(normal_in_sensor(scene_.sensor, face_forward(v.at.frame.z, v.wo), time), camera_normal_,
                  slot, on_surface);
  }
  if (scene_.aovs.uv) {
    scatter(v.surface.uv.x, u_, slot, on_surface);
    scatter(v.surface.uv.y, v_, slot, on_surface);
  }
}

void FirstHits::record_hit(const Hit& found, Float shape, Float instance, Int slot, Mask hit) {
  const Int material = gather_member(scene_.shapes.shapes.data(), &ShapeRecord::material, found.shape, hit);
  scatter(shape, shape_, slot, hit);
  scatter(to_float(material) + 1.0f, material_, slot, hit);
  // A shape that nothing places is told apart from instances by its sign.
  scatter(select(instance > 0.0f, instance, -shape), asset_, slot, hit);
  if (scene_.aovs.motion && scene_.any_motion) record_motion(found, slot, hit);
}

void FirstHits::record_motion(const Hit& found, Int slot, Mask hit) {
  const ShapeTable& table = scene_.shapes;
  alignas(64) std::int32_t instance[kWidth], upper[kWidth], at[kWidth];
  found.instance.store(instance), found.upper.store(upper), slot.store(at);
  Vec3 open{Float(0.0f), Float(0.0f), Float(0.0f)}, closed = open;
  alignas(64) float places[2][3][kWidth] = {};
  for (std::uint32_t bits = hit.bits(); bits != 0; bits &= bits - 1) {
    const int lane = std::countr_zero(bits);
    const int sample = at[lane];
    const Point p{{position_.x[sample], position_.y[sample], position_.z[sample]}};
    const auto map_at = [&](float time) -> ExactAffine {
      if (instance[lane] < 0) return {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
      if (table.nested())
        return map_of_place(table, place_number(instance[lane], upper[lane]), time).render_from_object;
      return placement_at(table, table.instances[static_cast<std::size_t>(instance[lane])], time);
    };
    const Point local = moved(inverse(map_at(time_[sample])), p);
    for (int end = 0; end < 2; ++end) {
      const Point place = moved(map_at(static_cast<float>(end)), local);
      for (int i = 0; i < 3; ++i) places[end][i][lane] = static_cast<float>(place.x[i]);
    }
  }
  open = {Float::load(places[0][0]), Float::load(places[0][1]), Float::load(places[0][2])};
  closed = {Float::load(places[1][0]), Float::load(places[1][1]), Float::load(places[1][2])};
  const Vec2 middle{Float(0.5f), Float(0.5f)};
  const SensorConnection from = connect_to_sensor(scene_.sensor, open, middle, Float(0.0f), hit);
  const SensorConnection to = connect_to_sensor(scene_.sensor, closed, middle, Float(1.0f), hit);
  const Mask seen = hit & from.valid & to.valid;
  scatter(to.raster.x - from.raster.x, motion_u_, slot, seen);
  scatter(to.raster.y - from.raster.y, motion_v_, slot, seen);
}

float* FirstHits::put(int slot, Float weight, Mask covered, float* to, std::size_t stride) const {
  const AovRequest& aovs = scene_.aovs;
  const auto put_raw = [&](Float value) {
    value.store_unaligned(to);
    to += stride;
  };
  const auto put = [&](Float value) { put_raw(select_or_zero(is_summable(value), value) * weight); };
  const auto put_lanes = [&](const float* lanes) { put(Float::load(lanes + slot)); };
  if (aovs.position) {
    const float* const lanes[] = {position_.x, position_.y, position_.z};
    for (int i = 0; i < 3; ++i)
      put(select_or_zero(covered, Float::load(lanes[i] + slot) + scene_.render_origin[i]));
  }
  if (aovs.camera_normal) {
    for (const float* const lanes : {camera_normal_.x, camera_normal_.y, camera_normal_.z}) put_lanes(lanes);
  }
  if (aovs.uv) put_lanes(u_), put_lanes(v_);
  if (aovs.motion) put_lanes(motion_u_), put_lanes(motion_v_);
  if (aovs.material_id) put_raw(Float::load(material_ + slot));
  const auto put_entry = [&](const float* lanes) {
    const Float identifier = Float::load(lanes + slot);
    put_raw(identifier);
    put_raw(select_or_zero(identifier != 0.0f, weight));
  };
  if (aovs.crypto_object) put_entry(shape_);
  if (aovs.crypto_material) put_entry(material_);
  if (aovs.crypto_asset) put_entry(asset_);
  return to;
}

}  // namespace tessera::render::TESSERA_ISA
