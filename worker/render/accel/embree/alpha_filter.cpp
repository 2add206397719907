#include "render/accel/embree/alpha_filter.h"

#include "render/color/texture.h"
#include "render/sampling/hash.h"
#include "render/shape/shape_table.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

void filter_alpha(const RTCFilterFunctionNArguments* args) {
  const auto& geometry = *static_cast<const AlphaGeometry*>(args->geometryUserPtr);
  const ShapeRecord& shape = geometry.shapes->shapes[geometry.shape];
  for (unsigned first = 0; first < args->N; first += kWidth) {
    const unsigned lanes = args->N - first < kWidth ? args->N - first : kWidth;
    alignas(64) float ray[6][kWidth] = {};
    alignas(64) float uv[2][kWidth] = {};
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
      uv[0][i] = RTCHitN_u(args->hit, args->N, j);
      uv[1][i] = RTCHitN_v(args->hit, args->N, j);
      primitive[i] = static_cast<std::int32_t>(RTCHitN_primID(args->hit, args->N, j));
    }
    const Mask active = Int::load(valid) != 0;
    Float alpha(shape.alpha);
    if (shape.alpha_texture >= 0) {
      const Hit hit{Float(0.0f),          Float::load(uv[0]),  Float::load(uv[1]),
                    Int::load(primitive), Int(geometry.shape), Int(-1)};
      const Vec3 o{Float::load(ray[0]), Float::load(ray[1]), Float::load(ray[2])};
      const Vec3 d{Float::load(ray[3]), Float::load(ray[4]), Float::load(ray[5])};
      const Surface surface = surface_at(*geometry.shapes, hit, o, d, active, false);
      alpha = eval_texture_scalar(*geometry.textures, shape.alpha_texture, texture_point(surface), active);
    }
    UInt h = bit_cast<std::uint32_t>(Int::load(primitive));
    for (const auto& component : ray) h = hash(h, bit_cast<std::uint32_t>(Float::load(component)));
    const std::uint32_t rejected = (active & (to_unit_float(h) >= alpha)).bits();
    for (unsigned i = 0; i < lanes; ++i) {
      if (rejected >> i & 1) args->valid[first + i] = 0;
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
