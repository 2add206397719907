// Embree's callbacks for primitives of our own: between its packets and wide values.
#pragma once

#include "render/accel/embree.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Up to 16 rays of a callback's packet. Roots are wanted in (t_near, t_far).
struct PrimitiveRays {
  Vec3 o, d;
  Float t_near, t_far;
  Mask active;
};

/// Calls f(first lane, roots, bits of the lanes that hit) for every 16 rays. `solve` gives the nearest root
/// of each active lane, or a negative number.
template <class Solve, class F>
void for_each_root(const int* valid, RTCRayN* ray, unsigned n, Solve&& solve, F&& f) {
  for (unsigned first = 0; first < n; first += kWidth) {
    const int lanes = static_cast<int>(n - first < kWidth ? n - first : kWidth);
    alignas(64) float f_[8][kWidth] = {};
    alignas(64) std::int32_t v[kWidth] = {};
    for (int i = 0; i < lanes; ++i) {
      const unsigned j = first + static_cast<unsigned>(i);
      v[i] = valid[j];
      f_[0][i] = RTCRayN_org_x(ray, n, j);
      f_[1][i] = RTCRayN_org_y(ray, n, j);
      f_[2][i] = RTCRayN_org_z(ray, n, j);
      f_[3][i] = RTCRayN_dir_x(ray, n, j);
      f_[4][i] = RTCRayN_dir_y(ray, n, j);
      f_[5][i] = RTCRayN_dir_z(ray, n, j);
      f_[6][i] = RTCRayN_tnear(ray, n, j);
      f_[7][i] = RTCRayN_tfar(ray, n, j);
    }
    const auto load = [&](int k) { return Float::load(f_[k]); };
    const PrimitiveRays rays{
        {load(0), load(1), load(2)}, {load(3), load(4), load(5)}, load(6), load(7), Int::load(v) != 0};
    const Float t = solve(rays);
    alignas(64) float roots[kWidth];
    t.store(roots);
    f(first, roots, (rays.active & (t >= 0.0f)).bits());
  }
}

template <class Solve>
void intersect_primitive(const RTCIntersectFunctionNArguments* args, Solve&& solve) {
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

template <class Solve>
void occluded_primitive(const RTCOccludedFunctionNArguments* args, Solve&& solve) {
  for_each_root(args->valid, args->ray, args->N, solve,
                [&](unsigned first, const float*, std::uint32_t bits) {
                  for (; bits != 0; bits &= bits - 1) {
                    RTCRayN_tfar(args->ray, args->N, first + static_cast<unsigned>(__builtin_ctz(bits))) =
                        -__builtin_inff();
                  }
                });
}

}  // namespace tessera::render::TESSERA_ISA
