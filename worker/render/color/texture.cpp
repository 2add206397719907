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

Spectrum checkerboard(const TextureTable& table, const TextureNode& node, Vec2 uv, Mask active) {
  const Vec2 st = map_uv(node, uv);
  const Float sum = floor(st.x) + floor(st.y);
  const Mask odd = sum - 2.0f * floor(sum * 0.5f) != 0.0f;
  const Mask on_even = and_not(active, odd), on_odd = active & odd;
  Spectrum result(0.0f);
  if (any(on_even)) result = eval_texture(table, node.inputs[0], uv, on_even);
  if (any(on_odd)) result += eval_texture(table, node.inputs[1], uv, on_odd);
  return result;
}

}  // namespace

Spectrum eval_texture(const TextureTable& table, int texture, Vec2 uv, Mask active) {
  const TextureNode& node = table.nodes[static_cast<std::size_t>(texture)];
  switch (node.kind) {
    case TextureKind::kConstant:
      return constant(node, active);
    case TextureKind::kImage:
      return image(node, uv, active);
    case TextureKind::kCheckerboard:
      return checkerboard(table, node, uv, active);
    case TextureKind::kScale:
      return eval_texture(table, node.inputs[0], uv, active) * eval_texture(table, node.inputs[1], uv, active);
    case TextureKind::kMix: {
      const Float amount = eval_texture_scalar(table, node.inputs[2], uv, active);
      return lerp(amount, eval_texture(table, node.inputs[0], uv, active),
                  eval_texture(table, node.inputs[1], uv, active));
    }
  }
  return Spectrum(0.0f);
}

Float eval_texture_scalar(const TextureTable& table, int texture, Vec2 uv, Mask active) {
  return eval_texture(table, texture, uv, active).mean();
}

}  // namespace tessera::render::TESSERA_ISA
