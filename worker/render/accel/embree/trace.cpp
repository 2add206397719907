#include "render/accel/embree/trace.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/accel/embree/alpha_filter.h"
#include "render/accel/embree/analytic_geometry.h"
#include "render/accel/embree/packet.h"
#include "render/accel/embree/trace_inner.h"
#include "render/shape/place.h"

namespace tessera::render::TESSERA_ISA {

namespace {

using FloatTag = Tag<float>;
using UIntTag = Tag<std::uint32_t>;

/// -1 for the first `n` lanes of a packet.
void set_valid(int n, int* valid) {
  for (int i = 0; i < kPacket; ++i) valid[i] = i < n ? -1 : 0;
}

void copy(const float* from, float* to) { hn::Store(hn::Load(FloatTag(), from), FloatTag(), to); }
void fill(float value, float* to) { hn::Store(hn::Set(FloatTag(), value), FloatTag(), to); }
void fill(std::uint32_t value, unsigned* to) {
  hn::Store(hn::Set(UIntTag(), value), UIntTag(), reinterpret_cast<std::uint32_t*>(to));
}

void load_rays(const RayArrays& rays, int first, RayPacket& packet) {
  copy(rays.ox + first, packet.org_x);
  copy(rays.oy + first, packet.org_y);
  copy(rays.oz + first, packet.org_z);
  copy(rays.dx + first, packet.dir_x);
  copy(rays.dy + first, packet.dir_y);
  copy(rays.dz + first, packet.dir_z);
  fill(0.0f, packet.tnear);
  if (rays.time) {
    copy(rays.time + first, packet.time);
  } else {
    fill(0.0f, packet.time);
  }
  fill(0xffffffffu, packet.mask);
  fill(0u, packet.id);
  fill(0u, packet.flags);
}

/// Largest coordinate of a ray. Embree's own limit is 1.8e18: where its assertions are on, a ray beyond it,
/// or one that is not finite, ends the program.
constexpr float kFarthest = 1.8e18f;

/// Rays of a packet that Embree takes. The others meet nothing and are blocked.
auto sound_rays(const RayArrays& rays, int first) {
  const FloatTag tag;
  const auto most = hn::Set(tag, kFarthest);
  auto sound = hn::Le(hn::Abs(hn::Load(tag, rays.ox + first)), most);
  for (const float* x : {rays.oy, rays.oz, rays.dx, rays.dy, rays.dz}) {
    sound = hn::And(sound, hn::Le(hn::Abs(hn::Load(tag, x + first)), most));
  }
  return sound;
}

bool is_sound(const RayArrays& rays, int i) {
  for (const float* x : {rays.ox, rays.oy, rays.oz, rays.dx, rays.dy, rays.dz}) {
    if (!(std::abs(x[i]) <= kFarthest)) return false;
  }
  return true;
}

/// -1 for those of the first `n` rays from `first` on that are sound.
void set_valid(const RayArrays& rays, int first, int n, int* valid) {
  const Tag<std::int32_t> tag;
  set_valid(n, valid);
  const auto sound = hn::RebindMask(tag, sound_rays(rays, first));
  hn::Store(hn::IfThenElseZero(sound, hn::Load(tag, valid)), tag, valid);
}

RTCRay single_ray(const RayArrays& rays, int i, float distance) {
  RTCRay ray{};
  ray.org_x = rays.ox[i], ray.org_y = rays.oy[i], ray.org_z = rays.oz[i];
  ray.dir_x = rays.dx[i], ray.dir_y = rays.dy[i], ray.dir_z = rays.dz[i];
  ray.tfar = distance;
  ray.time = rays.time ? rays.time[i] : 0.0f;
  ray.mask = ~0u;
  return ray;
}

/// Instance of a hit, as HitArrays counts it.
std::int32_t instance_of(unsigned id, std::int32_t first_instance) {
  return static_cast<std::int32_t>(id) < 0 ? -1 : static_cast<std::int32_t>(id) - first_instance;
}

/// Sets what HitArrays says of the shape and the place of ray `ray` in a scene of objects in objects: from
/// Embree's ids of its hit, and what callbacks have found for it.
void set_place(const ShapeTable& shapes, unsigned geometry, unsigned instance, std::int64_t found, int ray,
               const HitArrays& hits) {
  std::int64_t place = -1;
  if (is_inner_hit(geometry)) {
    place = found;
  } else if (instance != RTC_INVALID_GEOMETRY_ID) {
    place = shapes.instances[instance - shapes.shapes.size()].first_place;
  }
  hits.shape[ray] =
      geometry == RTC_INVALID_GEOMETRY_ID ? -1 : static_cast<std::int32_t>(geometry & ~kInnerHit);
  hits.instance[ray] = place < 0 ? -1 : lower_part(place);
  if (hits.upper != nullptr) hits.upper[ray] = place < 0 ? 0 : upper_part(place);
}

void trace_nearest_single(RTCScene scene, const RayArrays& rays, int n, std::int32_t first_instance,
                          const HitArrays& hits, const ShapeTable* nested) {
  std::int64_t found = -1;
  TraceContext context(Traversal::kSingle, -1, &found);
  for (int i = 0; i < n; ++i) {
    RTCRayHit one{};
    one.ray = single_ray(rays, i, __builtin_inff());
    one.hit.geomID = one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    if (is_sound(rays, i)) context.intersect(scene, one);
    hits.t[i] = one.ray.tfar;
    hits.u[i] = one.hit.u, hits.v[i] = one.hit.v;
    hits.primitive[i] = static_cast<std::int32_t>(one.hit.primID);
    hits.shape[i] = static_cast<std::int32_t>(one.hit.geomID);
    hits.instance[i] = instance_of(one.hit.instID[0], first_instance);
    if (nested != nullptr) set_place(*nested, one.hit.geomID, one.hit.instID[0], found, i, hits);
  }
}

void trace_shadow_single(RTCScene scene, const RayArrays& rays, int n, float* distance_in_blocked_out) {
  TraceContext context(Traversal::kSingle);
  for (int i = 0; i < n; ++i) {
    RTCRay ray = single_ray(rays, i, distance_in_blocked_out[i]);
    context.occluded(scene, ray);
    distance_in_blocked_out[i] = ray.tfar;
  }
}

}  // namespace

void trace_nearest(RTCScene scene, const RayArrays& rays, int n, Traversal traversal,
                   std::int32_t first_instance, const HitArrays& hits, const ShapeTable* nested) {
  if (traversal == Traversal::kSingle)
    return trace_nearest_single(scene, rays, n, first_instance, hits, nested);
  std::int64_t found[kPacket];
  TraceContext context(traversal, -1, found);
  Packet packet;
  alignas(64) int valid[kPacket];
  for (int first = 0; first < n; first += kPacket) {
    set_valid(rays, first, n - first, valid);
    load_rays(rays, first, packet.ray);
    if (nested != nullptr) std::iota(packet.ray.id, packet.ray.id + kPacket, 0u);
    fill(__builtin_inff(), packet.ray.tfar);
    fill(RTC_INVALID_GEOMETRY_ID, packet.hit.geomID);
    fill(RTC_INVALID_GEOMETRY_ID, packet.hit.instID[0]);
    context.intersect(valid, scene, packet);

    copy(packet.ray.tfar, hits.t + first);
    copy(packet.hit.u, hits.u + first);
    copy(packet.hit.v, hits.v + first);
    std::copy_n(packet.hit.primID, kPacket, hits.primitive + first);
    std::copy_n(packet.hit.geomID, kPacket, hits.shape + first);
    for (int i = 0; i < kPacket; ++i)
      hits.instance[first + i] = instance_of(packet.hit.instID[0][i], first_instance);
    for (int i = 0; nested != nullptr && i < kPacket; ++i)
      set_place(*nested, packet.hit.geomID[i], packet.hit.instID[0][i], found[i], first + i, hits);
  }
}

void trace_shadow(RTCScene scene, const RayArrays& rays, int n, Traversal traversal,
                  float* distance_in_blocked_out) {
  if (n == 0) return;
  // Embree leaves rays alone whose distance is negative: they count as blocked.
  for (int i = 0; i < n; i += kPacket) {
    const auto distance = hn::Load(FloatTag(), distance_in_blocked_out + i);
    hn::Store(hn::IfThenElse(sound_rays(rays, i), distance, hn::Set(FloatTag(), -1.0f)), FloatTag(),
              distance_in_blocked_out + i);
  }
  if (traversal == Traversal::kSingle) return trace_shadow_single(scene, rays, n, distance_in_blocked_out);
  TraceContext context(traversal);
#if TESSERA_EMBREE == 3
  // Streams read whole arrays; constants are shared by all batches.
  constexpr int kChunk = 1024;
  alignas(64) static thread_local float zero[kChunk];
  alignas(64) static thread_local unsigned all[kChunk], none[kChunk];
  if (all[0] == 0) std::fill_n(all, kChunk, ~0u);
  for (int first = 0; first < n; first += kChunk) {
    const int count = std::min(kChunk, n - first);
    RTCRayNp stream{};
    stream.org_x = const_cast<float*>(rays.ox) + first;
    stream.org_y = const_cast<float*>(rays.oy) + first;
    stream.org_z = const_cast<float*>(rays.oz) + first;
    stream.dir_x = const_cast<float*>(rays.dx) + first;
    stream.dir_y = const_cast<float*>(rays.dy) + first;
    stream.dir_z = const_cast<float*>(rays.dz) + first;
    stream.tnear = zero;
    stream.time = rays.time ? const_cast<float*>(rays.time) + first : zero;
    stream.tfar = distance_in_blocked_out + first;
    stream.mask = all;
    stream.id = none;
    stream.flags = none;
    context.occluded_stream(scene, stream, static_cast<unsigned>(count));
  }
#else
  RayPacket packet;
  alignas(64) int valid[kPacket];
  for (int first = 0; first < n; first += kPacket) {
    set_valid(n - first, valid);
    load_rays(rays, first, packet);
    copy(distance_in_blocked_out + first, packet.tfar);
    context.occluded(valid, scene, packet);
    copy(packet.tfar, distance_in_blocked_out + first);
  }
#endif
}

namespace {

class EmbreeQuery final : public RayQuery {
 public:
  EmbreeQuery(RTCScene scene, const ShapeTable& shapes, bool single_rays)
      : scene_(scene),
        first_instance_(static_cast<std::int32_t>(shapes.shapes.size())),
        nested_(shapes.nested() ? &shapes : nullptr),
        single_rays_(single_rays) {}

  void nearest(const RayArrays& rays, int n, bool coherent, const HitArrays& hits) const override {
    trace_nearest(scene_, rays, n, traversal(coherent), first_instance_, hits, nested_);
  }
  void occluded(const RayArrays& rays, int n, float* distance_in_blocked_out) const override {
    trace_shadow(scene_, rays, n, traversal(false), distance_in_blocked_out);
  }

 private:
  Traversal traversal(bool coherent) const {
    return single_rays_ ? Traversal::kSingle : coherent ? Traversal::kCoherent : Traversal::kIncoherent;
  }

  RTCScene scene_;
  const std::int32_t first_instance_;
  const ShapeTable* const nested_;
  const bool single_rays_;
};

std::unique_ptr<RayQuery> make_embree_query(RTCScene scene, const ShapeTable& shapes, bool single_rays) {
  return std::make_unique<EmbreeQuery>(scene, shapes, single_rays);
}

}  // namespace

const EmbreeKernel& embree_kernel() {
  static constexpr EmbreeKernel kKernel{
      {&count_primitives, &bound_primitive, &intersect_primitive, &occluded_primitive, &filter_alpha,
       &intersect_inner, &occluded_inner},
      &make_embree_query};
  return kKernel;
}

}  // namespace tessera::render::TESSERA_ISA
