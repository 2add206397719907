#include "render/accel/structure/meet.h"

#include "render/accel/alpha.h"
#include "render/shape/analytic_shape.h"

namespace tessera::render::TESSERA_ISA {

bool meet_analytic(const Ray& ray, const ShapeTable& table, const TextureTable& textures,
                   const Primitive& primitive, float most, Meeting& meeting) {
  const Ray::Interval box = ray.within(primitive.corners[0], primitive.corners[1]);
  if (box.empty() || box.enter > most) return false;
  const ShapeRecord& shape = table.shapes[static_cast<std::size_t>(primitive.shape)];
  const ShapeRays rays{{Float(ray.of[0]), Float(ray.of[1]), Float(ray.of[2])},
                       {Float(ray.df[0]), Float(ray.df[1]), Float(ray.df[2])},
                       Float(0.0f),
                       Float(__builtin_inff()),  // searches by iteration end at other bits if told where to
                       Mask::first(1)};
  const bool has_holes = (shape.flags & kHasAlpha) != 0;
  const float t = (has_holes ? nearest_behind_holes(table, textures, primitive.shape, primitive.number, rays)
                             : analytic_shape(shape.kind)->nearest(table, shape, primitive.number, rays))
                      .lane(0);
  if (!(t > 0 && t <= most && t >= box.enter && t <= box.leave)) return false;
  meeting = {t, 0, 0};
  return true;
}

bool passes_through(const Ray& ray, const ShapeTable& table, const TextureTable& textures,
                    const Primitive& primitive, const Meeting& meeting) {
  const Vec3 o{Float(ray.of[0]), Float(ray.of[1]), Float(ray.of[2])};
  const Vec3 d{Float(ray.df[0]), Float(ray.df[1]), Float(ray.df[2])};
  const Hit hit{Float(meeting.t),      Float(meeting.u),     Float(meeting.v),
                Int(primitive.number), Int(primitive.shape), Int(-1)};
  return any(passes_alpha(table, textures, primitive.shape, hit, o, d, 0, Mask::first(1)));
}

}  // namespace tessera::render::TESSERA_ISA
