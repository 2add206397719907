#include "render/accel/alpha.h"

#include "render/color/texture.h"
#include "render/sampling/hash.h"

namespace tessera::render::TESSERA_ISA {

Mask passes_alpha(const ShapeTable& shapes, const TextureTable& textures, std::int32_t shape, const Hit& hit,
                  Vec3 o, Vec3 d, std::uint32_t crossing, Mask active) {
  const ShapeRecord& record = shapes.shapes[static_cast<std::size_t>(shape)];
  Float alpha(record.alpha);
  if (record.alpha_texture >= 0) {
    const Surface surface = surface_at(shapes, hit, o, d, active, false);
    alpha = eval_texture_scalar(textures, record.alpha_texture, texture_point(surface), active);
  }
  UInt h = bit_cast<std::uint32_t>(hit.primitive);
  for (const Float component : {o.x, o.y, o.z, d.x, d.y, d.z})
    h = hash(h, bit_cast<std::uint32_t>(component));
  if (crossing > 0) h = hash(h, UInt(crossing));
  return active & (to_unit_float(h) >= alpha);
}

}  // namespace tessera::render::TESSERA_ISA
