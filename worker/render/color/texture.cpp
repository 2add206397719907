#include "render/color/texture.h"

#include "render/color/image_lookup.h"
#include "render/color/mip_lookup.h"
#include "render/color/procedural.h"
#include "render/core/affine.h"
#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Coordinates beyond this are folded onto it: floats have no fraction left there, and indices stay in range.
constexpr float kLargestCoordinate = 4194304.0f;

/// Finite, whatever comes in.
Float tame(Float x) { return clamp(select(x == x, x, 0.0f), -kLargestCoordinate, kLargestCoordinate); }

/// Parameters that follow from a point of render space instead of the surface [pbrt-v4].
Vec2 projected_uv(const TextureNode& node, Vec3 point) {
  const Vec3 p = transform_point(node.texture_from_render, point);
  if (node.source == UvSource::kPlanar) return {p.x, p.y};
  Float phi = atan2(p.y, p.x);
  phi = select(phi < 0.0f, phi + 2 * kPi, phi) * (0.5f / kPi);
  if (node.source == UvSource::kCylindrical) return {phi, p.z};
  return {atan2(sqrt(sqr(p.x) + sqr(p.y)), p.z) * (1 / kPi), phi};
}

Vec2 map_uv(const TextureNode& node, const TexturePoint& at) {
  if (!node.plain_uv) {
    const Vec2 uv = node.source == UvSource::kSurface ? at.uv : projected_uv(node, at.p);
    return {tame(fma(node.scale_u, uv.x, fma(node.u_from_v, uv.y, node.offset_u))),
            tame(fma(node.scale_v, uv.y, fma(node.v_from_u, uv.x, node.offset_v)))};
  }
  return {tame(fma(node.scale_u, at.uv.x, node.offset_u)), tame(fma(node.scale_v, at.uv.y, node.offset_v))};
}

Color constant(const TextureNode& node, Mask active) { return select_or_zero(active, color_of(node.value)); }

/// The footprint in (s, t), of textures whose parameters follow from the point by way of differences.
TexelFootprint map_footprint(const TextureNode& node, const TexturePoint& at) {
  const auto mapped = [&](Vec2 uv) {
    return Vec2{fma(node.scale_u, uv.x, uv.y * node.u_from_v), fma(node.scale_v, uv.y, uv.x * node.v_from_u)};
  };
  if (node.source == UvSource::kSurface) return {mapped(at.duvdx), mapped(at.duvdy)};
  const Vec2 here = projected_uv(node, at.p);
  const auto difference = [&](Vec3 step) {
    const Vec2 there = projected_uv(node, at.p + step);
    Vec2 d{there.x - here.x, there.y - here.y};
    // Angles go round.
    if (node.source == UvSource::kSpherical) d.y = d.y - floor(d.y + 0.5f);
    if (node.source == UvSource::kCylindrical) d.x = d.x - floor(d.x + 0.5f);
    return mapped({tame(d.x), tame(d.y)});
  };
  return {difference(at.dpdx), difference(at.dpdy)};
}

Color filtered_image(const TextureNode& node, const TexturePoint& at, Vec2 st, Mask active) {
  const MipLookup lookup{node.image->pyramid, node.wrap, node.channel};
  if (!at.has_footprint) return lookup.bilinear(st, active);
  const TexelFootprint footprint = map_footprint(node, at);
  return node.filter == TexelFilter::kEwa ? lookup.elliptic(st, footprint, node.max_anisotropy, active)
                                          : lookup.trilinear(st, footprint, active);
}

Color plain_image(const TextureNode& node, Vec2 st, Mask active) {
  const ImageLookup lookup{*node.image, node.wrap, node.channel};
  return node.filter == TexelFilter::kNearest ? lookup.nearest(st, active) : lookup.bilinear(st, active);
}

Color image(const TextureNode& node, const TexturePoint& at, Mask active) {
  const Vec2 st = map_uv(node, at);
  Color value =
      is_filtered(node.filter) ? filtered_image(node, at, st, active) : plain_image(node, st, active);
  value = value * node.scale;
  if (node.invert) value = max(Color(1.0f) - value, 0.0f);
  return select_or_zero(active, value);
}

/// The first input where `first`, else the second.
Color either(const TextureTable& table, const TextureNode& node, const TexturePoint& at, Mask first,
             Mask active) {
  const Mask on_first = active & first, on_second = and_not(active, first);
  Color result(0.0f);
  if (any(on_first)) result = eval_texture(table, node.inputs[0], at, on_first);
  if (any(on_second)) result += eval_texture(table, node.inputs[1], at, on_second);
  return result;
}

Color checkerboard(const TextureTable& table, const TextureNode& node, const TexturePoint& at, Mask active) {
  Float sum;
  if (node.solid) {
    const Vec3 p = transform_point(node.texture_from_render, at.p);
    sum = floor(tame(p.x)) + floor(tame(p.y)) + floor(tame(p.z));
  } else {
    const Vec2 st = map_uv(node, at);
    sum = floor(st.x) + floor(st.y);
  }
  return either(table, node, at, sum - 2.0f * floor(sum * 0.5f) == 0.0f, active);
}

Color direction_mix(const TextureTable& table, const TextureNode& node, const TexturePoint& at, Mask active) {
  const Vec3 direction{Float(node.direction[0]), Float(node.direction[1]), Float(node.direction[2])};
  return lerp(abs(dot(at.n, direction)), eval_texture(table, node.inputs[1], at, active),
              eval_texture(table, node.inputs[0], at, active));
}

/// Interpolated over the triangle, or of the whole of it; black on shapes that have no such attribute.
Color mesh_attribute(const TextureTable& table, const TextureNode& node, const TexturePoint& at,
                     Mask active) {
  Color result(0.0f);
  for_each_distinct(at.shape, active & (at.shape >= 0), [&](std::int32_t shape, Mask lanes) {
    const std::size_t slot = table.attribute_slot(shape, node.attribute);
    if (slot >= table.attribute_of_shape.size() || table.attribute_of_shape[slot] < 0) return;
    const MeshAttribute& attribute =
        table.attributes[static_cast<std::size_t>(table.attribute_of_shape[slot])];
    const float* values = attribute.values.data();
    const std::int32_t corners = attribute.per_face ? 1 : 3, channels = attribute.channels;
    for (int c = 0; c < kBands; ++c) {
      const Int first = at.primitive * (corners * channels) + (channels == kBands ? c : 0);
      Float value = gather(values, first, lanes);
      if (!attribute.per_face) {
        const Float b1 = at.barycentric.x, b2 = at.barycentric.y;
        value = value * (1.0f - b1 - b2) + gather(values + channels, first, lanes) * b1 +
                gather(values + 2 * channels, first, lanes) * b2;
      }
      result.c[c] = select(lanes, value * node.scale, result.c[c]);
    }
  });
  return result;
}

}  // namespace

Color eval_texture(const TextureTable& table, int texture, const TexturePoint& at, Mask active) {
  const TextureNode& node = table.nodes[static_cast<std::size_t>(texture)];
  switch (node.kind) {
    case TextureKind::kConstant:
      return constant(node, active);
    case TextureKind::kImage:
      return image(node, at, active);
    case TextureKind::kCheckerboard:
      return checkerboard(table, node, at, active);
    case TextureKind::kDots:
      return either(table, node, at, inside_dot(map_uv(node, at)), active);
    case TextureKind::kNoise:
      return select_or_zero(active, noise_texture(node, transform_point(node.texture_from_render, at.p)));
    case TextureKind::kDirectionMix:
      return direction_mix(table, node, at, active);
    case TextureKind::kMeshAttribute:
      return mesh_attribute(table, node, at, active);
    case TextureKind::kScale:
      return eval_texture(table, node.inputs[0], at, active) *
             eval_texture(table, node.inputs[1], at, active);
    case TextureKind::kMix: {
      const Float amount = eval_texture_scalar(table, node.inputs[2], at, active);
      return lerp(amount, eval_texture(table, node.inputs[0], at, active),
                  eval_texture(table, node.inputs[1], at, active));
    }
  }
  return Color(0.0f);
}

Float eval_texture_scalar(const TextureTable& table, int texture, const TexturePoint& at, Mask active) {
  return eval_texture(table, texture, at, active).mean();
}

}  // namespace tessera::render::TESSERA_ISA
