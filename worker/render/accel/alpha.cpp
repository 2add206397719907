#include "render/accel/alpha.h"

#include "render/color/texture.h"
#include "render/sampling/hash.h"
#include "render/shape/shape_table.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

Mask let_pass(const ShapeTable& shapes, const TextureTable& textures, std::int32_t shape, Int primitive,
              Float u, Float v, Vec3 o, Vec3 d, Mask active) {
  const ShapeRecord& record = shapes.shapes[static_cast<std::size_t>(shape)];
  Float alpha(record.alpha);
  if (record.alpha_texture >= 0) {
    const Hit hit{Float(0.0f), u, v, primitive, Int(shape), Int(-1)};
    const Surface surface = surface_at(shapes, hit, o, d, active, false);
    alpha = eval_texture_scalar(textures, record.alpha_texture, texture_point(surface), active);
  }
  UInt h = bit_cast<std::uint32_t>(primitive);
  for (const Float component : {o.x, o.y, o.z, d.x, d.y, d.z})
    h = hash(h, bit_cast<std::uint32_t>(component));
  return active & (to_unit_float(h) >= alpha);
}

}  // namespace tessera::render::TESSERA_ISA
