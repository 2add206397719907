#include "render/accel/embree/analytic_geometry.h"

#include <algorithm>

#include "render/accel/alpha.h"
#include "render/accel/embree/shape_geometry.h"
#include "render/shape/analytic_shape.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// The first `lanes` of 16 numbers, then zeros.
template <class T>
TESSERA_INLINE Wide<T> first_lanes(const T* from, unsigned lanes) {
  if (lanes == kWidth) return Wide<T>::load_unaligned(from);
  alignas(64) T all[kWidth] = {};
  if (lanes == kPartWidth) {  // a packet, by one vector
    hn::Store(hn::LoadU(Tag<T>(), from), Tag<T>(), all);
  } else {
    std::copy_n(from, lanes, all);
  }
  return Wide<T>::load(all);
}

/// Calls f(first lane, roots, bits of the lanes that hit) for every 16 rays. `solve` gives the nearest root
/// of each active lane, or a negative number.
template <class Solve, class F>
void for_each_root(const int* valid, RTCRayN* ray, unsigned n, Solve&& solve, F&& f) {
  for (unsigned first = 0; first < n; first += kWidth) {
    const unsigned lanes = n - first < kWidth ? n - first : kWidth;
    // The rays' members are arrays of n.
    const auto load = [&](const float& member) { return first_lanes(&member, lanes); };
    const ShapeRays rays{{load(RTCRayN_org_x(ray, n, first)), load(RTCRayN_org_y(ray, n, first)),
                          load(RTCRayN_org_z(ray, n, first))},
                         {load(RTCRayN_dir_x(ray, n, first)), load(RTCRayN_dir_y(ray, n, first)),
                          load(RTCRayN_dir_z(ray, n, first))},
                         load(RTCRayN_tnear(ray, n, first)),
                         load(RTCRayN_tfar(ray, n, first)),
                         first_lanes(valid + first, lanes) != 0};
    const Float t = solve(rays);
    alignas(64) float roots[kWidth];
    t.store(roots);
    f(first, roots, (rays.active & (t >= 0.0f)).bits());
  }
}

/// Target of a geometry's user pointer.
struct Primitive {
  const ShapeGeometry& geometry;
  const ShapeTable& table;
  const ShapeRecord& shape;
  const AnalyticShape& model;
  std::int32_t index;

  Primitive(const void* user_pointer, unsigned primitive)
      : geometry(*static_cast<const ShapeGeometry*>(user_pointer)),
        table(*geometry.table),
        shape(table.shapes[static_cast<std::size_t>(geometry.shape)]),
        model(*analytic_shape(shape.kind)),
        index(static_cast<std::int32_t>(primitive)) {}

  bool has_holes() const { return (shape.flags & kHasAlpha) != 0; }
  Float operator()(const ShapeRays& rays) const {
    return has_holes() ? nearest_behind_holes(table, *geometry.textures, geometry.shape, index, rays)
                       : model.nearest(table, shape, index, rays);
  }
  Mask occluded(const ShapeRays& rays) const {
    return has_holes() ? rays.active & ((*this)(rays) >= 0.0f) : model.occluded(table, shape, index, rays);
  }
};

}  // namespace

unsigned count_primitives(const ShapeTable& table, std::int32_t shape) {
  const ShapeRecord& record = table.shapes[static_cast<std::size_t>(shape)];
  return static_cast<unsigned>(analytic_shape(record.kind)->primitive_count(table, record));
}

void bound_primitive(const RTCBoundsFunctionArguments* args) {
  const Primitive primitive(args->geometryUserPtr, args->primID);
  const ShapeBounds b = primitive.model.bounds(primitive.table, primitive.shape, primitive.index);
  args->bounds_o->lower_x = b.low[0], args->bounds_o->lower_y = b.low[1], args->bounds_o->lower_z = b.low[2];
  args->bounds_o->upper_x = b.high[0], args->bounds_o->upper_y = b.high[1],
  args->bounds_o->upper_z = b.high[2];
}

void intersect_primitive(const RTCIntersectFunctionNArguments* args) {
  const Primitive solve(args->geometryUserPtr, args->primID);
  const unsigned n = args->N;
  RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, n);
  RTCHitN* hit = RTCRayHitN_HitN(args->rayhit, n);
  for_each_root(args->valid, ray, n, solve, [&](unsigned first, const float* roots, std::uint32_t bits) {
    for (; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      const unsigned j = first + static_cast<unsigned>(i);
      RTCRayN_tfar(ray, n, j) = roots[i];
      RTCHitN_geomID(hit, n, j) = args->geomID;
      RTCHitN_primID(hit, n, j) = args->primID;
      RTCHitN_instID(hit, n, j, 0) = args->context->instID[0];
      RTCHitN_u(hit, n, j) = 0;
      RTCHitN_v(hit, n, j) = 0;
    }
  });
}

void occluded_primitive(const RTCOccludedFunctionNArguments* args) {
  const Primitive primitive(args->geometryUserPtr, args->primID);
  const auto solve = [&](const ShapeRays& rays) {
    return select(primitive.occluded(rays), Float(1.0f), -1.0f);
  };
  for_each_root(args->valid, args->ray, args->N, solve,
                [&](unsigned first, const float*, std::uint32_t bits) {
                  for (; bits != 0; bits &= bits - 1) {
                    RTCRayN_tfar(args->ray, args->N, first + static_cast<unsigned>(__builtin_ctz(bits))) =
                        -__builtin_inff();
                  }
                });
}

}  // namespace tessera::render::TESSERA_ISA
