#include "render/light/environment.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace tessera::render {
namespace {

/// The inverse of the linear part; false when there is none.
bool invert_linear(const Affine& a, Affine& inverse) {
  const auto m = [&](int r, int c) { return double{a.m[4 * r + c]}; };
  double cofactor[3][3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      cofactor[r][c] = m(r1, c1) * m(r2, c2) - m(r1, c2) * m(r2, c1);
    }
  }
  const double determinant = m(0, 0) * cofactor[0][0] + m(0, 1) * cofactor[0][1] + m(0, 2) * cofactor[0][2];
  if (!std::isfinite(1 / determinant)) return false;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) inverse.m[4 * r + c] = static_cast<float>(cofactor[c][r] / determinant);
  return true;
}

/// Four linear floats a texel. Those of the image itself where it has them: the system takes longer to give
/// out fresh memory than all arithmetic of this file.
void take_texels(TextureImage image, float scale, Environment& e) {
  if (image.format == TexelFormat::kFloat) {
    e.texels = std::move(image.texels32);
  } else {
    e.texels.resize(image.texels8.size() * 4);
    for (std::size_t i = 0; i < e.texels.size(); ++i)
      e.texels[i] = image.decode[image.texels8[i / 4] >> (8 * (i % 4)) & 255];
  }
  for (std::size_t i = 0; i < e.texels.size(); ++i) {
    const float v = e.texels[i] * scale;
    e.texels[i] = std::isfinite(v) && v > 0 ? v : 0.0f;
  }
}

float brightness(const Environment& e, std::int32_t x, std::int32_t y) {
  const float* t = &e.texels[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) +
                                  static_cast<std::size_t>(x))];
  return (t[0] + t[1] + t[2]) * (1.0f / 3);
}

/// Integral over a texel of the map as it is looked up (see infinite.cpp): the interpolated map reaches half
/// a texel into its neighbours, and must be sampled wherever it is not black.
float lookup_mean(const Environment& e, std::int32_t x, std::int32_t y) {
  if (e.mapping == EnvironmentMapping::kEqualAreaOctahedral) return brightness(e, x, y);
  constexpr float kWeight[3] = {0.125f, 0.75f, 0.125f};
  float sum = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const std::int32_t row = std::min(std::max(y + dy, 0), e.height - 1);
      sum += kWeight[dx + 1] * kWeight[dy + 1] * brightness(e, (x + dx + e.width) % e.width, row);
    }
  }
  return sum;
}

/// Solid angle of a texel of row `y`, relative to others.
double row_weight(const Environment& e, std::int32_t y) {
  if (e.mapping == EnvironmentMapping::kEqualAreaOctahedral) return 1;
  const double step = std::numbers::pi / e.height;
  return std::cos(step * y) - std::cos(step * (y + 1));
}

/// Integral of the mean of R, G and B over all directions.
double flux_of(const Environment& e) {
  double sum = 0, weights = 0;
  for (std::int32_t y = 0; y < e.height; ++y) {
    double row = 0;
    for (std::int32_t x = 0; x < e.width; ++x) row += brightness(e, x, y);
    sum += row * row_weight(e, y);
    weights += e.width * row_weight(e, y);
  }
  return weights > 0 ? 4 * std::numbers::pi * sum / weights : 0;
}

/// Below this share of the light, what is brighter than the mean is not worth a shadow ray.
constexpr float kSmallestShare = 0.02f;

/// Takes the mean off the weights of all texels, down to zero; returns which part of their sum is left, 0
/// when all weights are as before.
float leave_mean_to_bsdfs(const Environment& e, std::vector<float>& weights) {
  double sum = 0, solid_angle = 0;
  for (const float w : weights) sum += w;
  for (std::int32_t y = 0; y < e.height; ++y) solid_angle += e.width * row_weight(e, y);
  const double mean = sum / solid_angle;
  /// Calls `f` with each weight and what is left of it.
  const auto for_each = [&](auto f) {
    std::size_t i = 0;
    for (std::int32_t y = 0; y < e.height; ++y) {
      const double low = mean * row_weight(e, y);
      for (std::int32_t x = 0; x < e.width; ++x, ++i)
        f(weights[i], static_cast<float>(std::max(weights[i] - low, 0.0)));
    }
  };
  double left = 0;
  for_each([&](float&, float above) { left += above; });
  if (!(left > kSmallestShare * sum)) return 0;
  for_each([](float& weight, float above) { weight = above; });
  return static_cast<float>(left / sum);
}

}  // namespace

absl::Status check_environment_size(std::int32_t width, std::int32_t height, EnvironmentMapping mapping) {
  if (width <= 0 || height <= 0) return absl::InvalidArgumentError("the environment image is empty");
  if (mapping != EnvironmentMapping::kEqualAreaOctahedral || width == height) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("an octahedral environment image must be square, this one is ", width, " x ", height));
}

absl::StatusOr<Environment> build_environment(TextureImage image, EnvironmentMapping mapping, float scale,
                                              const Affine& render_from_light, bool compensate) {
  Environment e;
  e.mapping = mapping;
  e.render_from_light = render_from_light;
  e.render_from_light.m[3] = e.render_from_light.m[7] = e.render_from_light.m[11] = 0;
  if (!invert_linear(e.render_from_light, e.light_from_render))
    return absl::InvalidArgumentError("the environment's transform is singular");
  if (mapping == EnvironmentMapping::kUniform) {
    if (compensate) e.sampled_share = 0;
    return e;
  }

  if (auto s = check_environment_size(image.width, image.height, mapping); !s.ok()) return s;
  e.width = image.width;
  e.height = image.height;
  take_texels(std::move(image), scale, e);
  e.flux = flux_of(e);

  std::vector<float> weights(e.texels.size() / 4);
  std::size_t i = 0;
  for (std::int32_t y = 0; y < e.height; ++y) {
    const auto weight = static_cast<float>(row_weight(e, y));
    for (std::int32_t x = 0; x < e.width; ++x) weights[i++] = lookup_mean(e, x, y) * weight;
  }
  if (compensate) e.sampled_share = leave_mean_to_bsdfs(e, weights);
  e.distribution = Piecewise2d::build(weights, e.width, e.height);
  // Beside the radiance, so that a sample reads one cache line for both.
  for (std::size_t cell = 0; cell < weights.size(); ++cell)
    e.texels[4 * cell + 3] = e.distribution.density[cell];
  return e;
}

}  // namespace tessera::render
