#include "render/color/texture.h"

#include "render/color/image_lookup.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Coordinates beyond this are folded onto it: floats have no fraction left there, and indices stay in range.
constexpr float kLargestCoordinate = 4194304.0f;

/// Finite, whatever comes in.
Float tame(Float x) { return clamp(select(x == x, x, 0.0f), -kLargestCoordinate, kLargestCoordinate); }

Vec2 map_uv(const TextureNode& node, Vec2 uv) {
  return {tame(fma(node.scale_u, uv.x, node.offset_u)), tame(fma(node.scale_v, uv.y, node.offset_v))};
}

Spectrum constant(const TextureNode& node, Mask active) {
  Spectrum result;
  for (int i = 0; i < kSpectrumLanes; ++i) result.c[i] = select_or_zero(active, Float(node.value[i]));
  return result;
}

Spectrum image(const TextureNode& node, Vec2 uv, Mask active) {
  const ImageLookup lookup{*node.image, node.wrap, node.channel};
  const Vec2 st = map_uv(node, uv);
  Spectrum value = node.nearest ? lookup.nearest(st, active) : lookup.bilinear(st, active);
  value = value * node.scale;
  if (node.invert) value = max(Spectrum(1.0f) - value, 0.0f);
  return select_or_zero(active, value);
}

Spectrum checkerboard(const TextureTable& table, const TextureNode& node, const TexturePoint& at, Mask active) {
  const Vec2 st = map_uv(node, at.uv);
  const Float sum = floor(st.x) + floor(st.y);
  const Mask odd = sum - 2.0f * floor(sum * 0.5f) != 0.0f;
  const Mask on_even = and_not(active, odd), on_odd = active & odd;
  Spectrum result(0.0f);
  if (any(on_even)) result = eval_texture(table, node.inputs[0], at, on_even);
  if (any(on_odd)) result += eval_texture(table, node.inputs[1], at, on_odd);
  return result;
}

/// Interpolated over the triangle, or of the whole of it; black on shapes that have no such attribute.
Spectrum mesh_attribute(const TextureTable& table, const TextureNode& node, const TexturePoint& at, Mask active) {
  Spectrum result(0.0f);
  for_each_distinct(at.shape, active & (at.shape >= 0), [&](std::int32_t shape, Mask lanes) {
    const auto slot = static_cast<std::size_t>(shape * table.attribute_names + node.attribute);
    if (slot >= table.attribute_of_shape.size() || table.attribute_of_shape[slot] < 0) return;
    const MeshAttribute& attribute = table.attributes[static_cast<std::size_t>(table.attribute_of_shape[slot])];
    const float* values = attribute.values.data();
    const std::int32_t corners = attribute.per_face ? 1 : 3, channels = attribute.channels;
    for (int c = 0; c < kSpectrumLanes; ++c) {
      const Int first = at.primitive * (corners * channels) + (channels == 3 ? c : 0);
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

Spectrum eval_texture(const TextureTable& table, int texture, const TexturePoint& at, Mask active) {
  const TextureNode& node = table.nodes[static_cast<std::size_t>(texture)];
  switch (node.kind) {
    case TextureKind::kConstant:
      return constant(node, active);
    case TextureKind::kImage:
      return image(node, at.uv, active);
    case TextureKind::kCheckerboard:
      return checkerboard(table, node, at, active);
    case TextureKind::kMeshAttribute:
      return mesh_attribute(table, node, at, active);
    case TextureKind::kScale:
      return eval_texture(table, node.inputs[0], at, active) * eval_texture(table, node.inputs[1], at, active);
    case TextureKind::kMix: {
      const Float amount = eval_texture_scalar(table, node.inputs[2], at, active);
      return lerp(amount, eval_texture(table, node.inputs[0], at, active),
                  eval_texture(table, node.inputs[1], at, active));
    }
  }
  return Spectrum(0.0f);
}

Float eval_texture_scalar(const TextureTable& table, int texture, const TexturePoint& at, Mask active) {
  return eval_texture(table, texture, at, active).mean();
}

}  // namespace tessera::render::TESSERA_ISA
