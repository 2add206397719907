#include "render/color/procedural.h"

#include "render/color/noise.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// pbrt's marble: a spline through colours, looked up along veins.
Color marble(const TextureNode& node, Vec3 p) {
  static constexpr float kColors[9][3] = {{0.58f, 0.58f, 0.6f}, {0.58f, 0.58f, 0.6f}, {0.58f, 0.58f, 0.6f},
                                          {0.5f, 0.5f, 0.5f},   {0.6f, 0.59f, 0.58f}, {0.58f, 0.58f, 0.6f},
                                          {0.58f, 0.58f, 0.6f}, {0.2f, 0.2f, 0.33f},  {0.58f, 0.58f, 0.6f}};
  constexpr int kSegments = 6;
  constexpr float kBrightness = 1.5f;
  p = p * Float(node.scale);
  const Float vein = fma(Float(node.variation), fractal_noise(p, node.roughness, node.octaves), p.y);
  // Sines of large angles lose their meaning long before they lose their accuracy.
  const Float along = fma(Float(0.5f), sin(clamp(vein, -39000.0f, 39000.0f)), Float(0.5f)) * kSegments;
  const Int first = min(to_int(along), kSegments - 1);
  const Float t = along - to_float(first), s = 1.0f - t;
  const Float weights[4] = {s * s * s, 3.0f * s * s * t, 3.0f * s * t * t, t * t * t};
  Color result(0.0f);
  for (int c = 0; c < kBands; ++c) {
    for (int k = 0; k < 4; ++k)
      result.c[c] = fma(weights[k], gather(&kColors[0][c], (first + k) * 3), result.c[c]);
    result.c[c] = min(result.c[c] * kBrightness, 1.0f);
  }
  return result;
}

}  // namespace

Color noise_texture(const TextureNode& node, Vec3 p) {
  switch (node.noise) {
    case NoiseKind::kFbm:
      return Color(fractal_noise(p, node.roughness, node.octaves));
    case NoiseKind::kWrinkled:
      return Color(turbulence(p, node.roughness, node.octaves));
    // Waves whose height follows a slow wind [pbrt-v4].
    case NoiseKind::kWindy:
      return Color(abs(fractal_noise(p * Float(0.1f), 0.5f, 3)) * fractal_noise(p, 0.5f, 6));
    case NoiseKind::kMarble:
      return marble(node, p);
  }
  return Color(0.0f);
}

Mask inside_dot(Vec2 st) {
  constexpr float kRadius = 0.35f, kMaxShift = 0.5f - kRadius;
  const Float s = floor(st.x + 0.5f), t = floor(st.y + 0.5f), half(0.5f);
  const Mask has_dot = noise({s + 0.5f, t + 0.5f, half}) > 0.0f;
  const Float s_centre = fma(Float(kMaxShift), noise({s + 1.5f, t + 2.8f, half}), s);
  const Float t_centre = fma(Float(kMaxShift), noise({s + 4.5f, t + 9.8f, half}), t);
  return has_dot & (sqr(st.x - s_centre) + sqr(st.y - t_centre) < kRadius * kRadius);
}

}  // namespace tessera::render::TESSERA_ISA
