#include "render/accel/embree/alpha_filter.h"

#include "render/accel/alpha.h"

namespace tessera::render::TESSERA_ISA {

void filter_alpha(const RTCFilterFunctionNArguments* args) {
  const auto& geometry = *static_cast<const AlphaGeometry*>(args->geometryUserPtr);
  for (unsigned first = 0; first < args->N; first += kWidth) {
    const unsigned lanes = args->N - first < kWidth ? args->N - first : kWidth;
    alignas(64) float ray[6][kWidth] = {};
    alignas(64) float uv[2][kWidth] = {}, time[kWidth] = {};
    alignas(64) std::int32_t primitive[kWidth] = {}, valid[kWidth] = {};
    for (unsigned i = 0; i < lanes; ++i) {
      const unsigned j = first + i;
      valid[i] = args->valid[j];
      ray[0][i] = RTCRayN_org_x(args->ray, args->N, j);
      ray[1][i] = RTCRayN_org_y(args->ray, args->N, j);
      ray[2][i] = RTCRayN_org_z(args->ray, args->N, j);
      ray[3][i] = RTCRayN_dir_x(args->ray, args->N, j);
      ray[4][i] = RTCRayN_dir_y(args->ray, args->N, j);
      ray[5][i] = RTCRayN_dir_z(args->ray, args->N, j);
      time[i] = RTCRayN_time(args->ray, args->N, j);
      uv[0][i] = RTCHitN_u(args->hit, args->N, j);
      uv[1][i] = RTCHitN_v(args->hit, args->N, j);
      primitive[i] = static_cast<std::int32_t>(RTCHitN_primID(args->hit, args->N, j));
    }
    const Mask active = Int::load(valid) != 0;
    const Hit hit{Float(0.0f),          Float::load(uv[0]),  Float::load(uv[1]),
                  Int::load(primitive), Int(geometry.shape), Int(-1),
                  Float::load(time)};
    const Vec3 o{Float::load(ray[0]), Float::load(ray[1]), Float::load(ray[2])};
    const Vec3 d{Float::load(ray[3]), Float::load(ray[4]), Float::load(ray[5])};
    const std::uint32_t rejected =
        passes_alpha(*geometry.shapes, *geometry.textures, geometry.shape, hit, o, d, 0, active).bits();
    for (unsigned i = 0; i < lanes; ++i) {
      if (rejected >> i & 1) args->valid[first + i] = 0;
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
