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

Float nearest_behind_holes(const ShapeTable& shapes, const TextureTable& textures, std::int32_t shape,
                           std::int32_t primitive, ShapeRays rays) {
  const ShapeRecord& record = shapes.shapes[static_cast<std::size_t>(shape)];
  const AnalyticShape& model = *analytic_shape(record.kind);
  Float t = model.nearest(shapes, record, primitive, rays);
  for (std::uint32_t crossing = 0;; ++crossing) {
    const Hit hit{t, Float(0.0f), Float(0.0f), Int(primitive), Int(shape), Int(-1)};
    rays.active =
        passes_alpha(shapes, textures, shape, hit, rays.o, rays.d, crossing, rays.active & (t >= 0.0f));
    if (none(rays.active)) return t;
    rays.t_near = select(rays.active, t, rays.t_near);
    t = select(rays.active, model.nearest(shapes, record, primitive, rays), t);
  }
}

}  // namespace tessera::render::TESSERA_ISA
