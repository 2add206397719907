#include "render/accel/embree/trace_inner.h"

#include <algorithm>

#include "render/accel/embree/packet.h"
#include "render/core/motion.h"
#include "render/shape/place.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// One instance in an object, as a callback meets it.
struct Inner {
  const InnerGeometry& geometry;
  const ShapeTable& table;
  const InstanceRecord& record;
  const PlaceContext& context;
  unsigned world_instance;  // Embree id of the one that led here; invalid where other callbacks have led on
  std::int64_t place;

  Inner(const void* user_pointer, unsigned primitive, const EmbreeContext* asked)
      : geometry(*static_cast<const InnerGeometry*>(user_pointer)),
        table(*geometry.table),
        record(table.inner[static_cast<std::size_t>(geometry.first) + primitive]),
        context(*static_cast<const PlaceContext*>(asked)),
        world_instance(asked->instID[0]),
        place(place_within(holder(), record)) {}

  std::int64_t holder() const {
    if (world_instance == RTC_INVALID_GEOMETRY_ID) return context.holder;
    return table.instances[world_instance - table.shapes.size()].first_place;
  }
  RTCScene scene() const { return (*geometry.objects)[static_cast<std::size_t>(record.object)]; }

  WideAffine map_at(Float time, Mask active) const {
    if (record.segments == 0) return broadcast(record.instance_from_render);
    const MovedAffine moved =
        affine_at(table.motion_steps.data(), Int(record.first_step), Int(record.segments), time, active);
    return inverse(moved.map);
  }

  /// Sets `inner` and `valid` to the rays from number `first` on, in the instance's space: kPacket of them,
  /// as far as there are any. Those that are valid have finite coordinates.
  void take_rays(RTCRayN* ray, const int* outer_valid, unsigned n, unsigned first, RayPacket& inner,
                 int* valid) const {
    alignas(64) float x[6][kWidth] = {};
    alignas(64) float time[kWidth] = {};
    alignas(64) std::int32_t active[kWidth] = {};
    for (int i = 0; i < kPacket; ++i) {
      const unsigned j = first + static_cast<unsigned>(i);
      const bool there = j < n && outer_valid[j] != 0;
      active[i] = valid[i] = there ? -1 : 0;
      if (!there) continue;
      x[0][i] = RTCRayN_org_x(ray, n, j), x[3][i] = RTCRayN_dir_x(ray, n, j);
      x[1][i] = RTCRayN_org_y(ray, n, j), x[4][i] = RTCRayN_dir_y(ray, n, j);
      x[2][i] = RTCRayN_org_z(ray, n, j), x[5][i] = RTCRayN_dir_z(ray, n, j);
      time[i] = RTCRayN_time(ray, n, j);
      inner.tnear[i] = RTCRayN_tnear(ray, n, j), inner.tfar[i] = RTCRayN_tfar(ray, n, j);
      inner.time[i] = time[i];
      inner.mask[i] = RTCRayN_mask(ray, n, j), inner.id[i] = RTCRayN_id(ray, n, j);
      inner.flags[i] = 0;
    }
    const auto load = [&](int k) { return Float::load(x[k]); };
    const WideAffine from = map_at(Float::load(time), Int::load(active) != 0);
    const Vec3 o = transform_point(from, {load(0), load(1), load(2)}),
               d = transform_vector(from, {load(3), load(4), load(5)});
    const Float moved[6] = {o.x, o.y, o.z, d.x, d.y, d.z};
    float* const to[6] = {inner.org_x, inner.org_y, inner.org_z, inner.dir_x, inner.dir_y, inner.dir_z};
    for (int k = 0; k < 6; ++k) {
      moved[k].store(x[k]);
      std::copy_n(x[k], kPacket, to[k]);
    }
  }
};

}  // namespace

void intersect_inner(const RTCIntersectFunctionNArguments* args) {
  const Inner inner(args->geometryUserPtr, args->primID, args->context);
  const unsigned n = args->N;
  RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, n);
  RTCHitN* hit = RTCRayHitN_HitN(args->rayhit, n);
  for (unsigned first = 0; first < n; first += kPacket) {
    Packet packet;
    alignas(64) int valid[kPacket];
    inner.take_rays(ray, args->valid, n, first, packet.ray, valid);
    std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(packet.hit.instID[0], kPacket, RTC_INVALID_GEOMETRY_ID);
    TraceContext(Traversal::kIncoherent, inner.place, inner.context.found)
        .intersect(valid, inner.scene(), packet);
    for (int i = 0; i < kPacket; ++i) {
      const unsigned geometry = packet.hit.geomID[i];
      if (valid[i] == 0 || geometry == RTC_INVALID_GEOMETRY_ID) continue;
      // A callback further down has noted its own place.
      if (!is_inner_hit(geometry)) inner.context.found[packet.ray.id[i]] = inner.place;
      const unsigned j = first + static_cast<unsigned>(i);
      RTCRayN_tfar(ray, n, j) = packet.ray.tfar[i];
      RTCHitN_u(hit, n, j) = packet.hit.u[i];
      RTCHitN_v(hit, n, j) = packet.hit.v[i];
      RTCHitN_primID(hit, n, j) = packet.hit.primID[i];
      RTCHitN_geomID(hit, n, j) = geometry | kInnerHit;
      RTCHitN_instID(hit, n, j, 0) = inner.world_instance;
    }
  }
}

void occluded_inner(const RTCOccludedFunctionNArguments* args) {
  const Inner inner(args->geometryUserPtr, args->primID, args->context);
  for (unsigned first = 0; first < args->N; first += kPacket) {
    RayPacket packet;
    alignas(64) int valid[kPacket];
    inner.take_rays(args->ray, args->valid, args->N, first, packet, valid);
    TraceContext(Traversal::kIncoherent, inner.place).occluded(valid, inner.scene(), packet);
    for (int i = 0; i < kPacket; ++i) {
      if (valid[i] != 0 && packet.tfar[i] < 0)
        RTCRayN_tfar(args->ray, args->N, first + static_cast<unsigned>(i)) = -__builtin_inff();
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
