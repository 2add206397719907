#include "render/accel/structure/meet.h"

#include "render/accel/alpha.h"
#include "render/accel/structure/has_normal.h"
#include "render/shape/analytic_shape.h"
#include "render/shape/key_vertices.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Where the ray itself, not its rounding to float, is within a box.
struct Crossing {
  double enter = 0, leave = __builtin_inf();
};
Crossing crossing(const Ray& ray, const float (&low)[3], const float (&high)[3]) {
  const double room = 0x1p-30 * ray.pad;  // more than doubles round off
  Crossing in;
  for (int k = 0; k < 3; ++k) {
    const double below = low[k] - room - ray.o[k], above = high[k] + room - ray.o[k];
    if (ray.d[k] == 0) {
      if (below > 0 || above < 0) in.leave = -1;
      continue;
    }
    const double a = below / ray.d[k], b = above / ray.d[k];
    in.enter = std::max(in.enter, std::min(a, b));
    in.leave = std::min(in.leave, std::max(a, b));
  }
  return in;
}

}  // namespace

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
  if (!(t > 0 && t >= box.enter && t <= box.leave)) return false;
  // Shapes are met in float. What a float of a far origin meets beside or before the shape's box would be
  // found by those walks alone that look there.
  const Crossing in = crossing(ray, primitive.corners[0], primitive.corners[1]);
  if (in.enter > in.leave) return false;
  meeting = {static_cast<float>(std::clamp<double>(t, in.enter, in.leave)), 0, 0};
  return meeting.t > 0 && meeting.t <= most;
}

bool meet_deforming(const Ray& ray, const ShapeTable& table, const Primitive& primitive, Meeting& meeting) {
  const Ray::Interval box = ray.within(primitive.corners[0], primitive.corners[1]);
  if (box.empty()) return false;
  float corners[3][3];
  corners_at(table, table.shapes[static_cast<std::size_t>(primitive.shape)], primitive.number, ray.time,
             corners);
  return meet_triangle(ray, corners, meeting) && has_normal(corners);
}

bool passes_through(const Ray& ray, const ShapeTable& table, const TextureTable& textures,
                    const Primitive& primitive, const Meeting& meeting) {
  const Vec3 o{Float(ray.of[0]), Float(ray.of[1]), Float(ray.of[2])};
  const Vec3 d{Float(ray.df[0]), Float(ray.df[1]), Float(ray.df[2])};
  const Hit hit{Float(meeting.t),     Float(meeting.u), Float(meeting.v), Int(primitive.number),
                Int(primitive.shape), Int(-1),          Float(ray.time)};
  return any(passes_alpha(table, textures, primitive.shape, hit, o, d, 0, Mask::first(1)));
}

}  // namespace tessera::render::TESSERA_ISA
