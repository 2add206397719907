#include "render/scene/light/photometric_map.h"

#include <ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace tessera::render {

using photometry::Luminaire;
using photometry::PlaneSystem;

// Half a turn about x, which takes -z to z, and then one of 37 degrees about z.
constexpr double kCosine = 0.79863551004729283, kSine = 0.60181502315204827;
const double kMapFromLuminaire[9] = {kCosine, kSine, 0, kSine, -kCosine, 0, 0, 0, -1};

namespace {

using Imath::V2d;
using Imath::V3d;

/// sampling/sphere_map.h in doubles [Clarberg 2008].
V3d direction_from_map(V2d uv) {
  const double u = 2 * uv.x - 1, v = 2 * uv.y - 1, au = std::abs(u), av = std::abs(v);
  const double signed_distance = 1 - (au + av), r = 1 - std::abs(signed_distance);
  const double phi = std::numbers::pi / 4 * (r == 0 ? 1 : (av - au) / r + 1);
  const double z = std::copysign(1 - r * r, signed_distance), sine = r * std::sqrt(2 - r * r);
  return {sine * std::copysign(std::cos(phi), u), sine * std::copysign(std::sin(phi), v), z};
}

V2d map_from_direction(const V3d& w) {
  const double ax = std::abs(w.x), ay = std::abs(w.y), az = std::abs(w.z);
  const double r = std::sqrt((ax * ax + ay * ay) / (1 + az));
  const double av = std::atan2(ay, ax) * (2 / std::numbers::pi) * r, au = r - av;
  const double fu = w.z < 0 ? 1 - av : au, fv = w.z < 0 ? 1 - au : av;
  return {std::clamp((std::copysign(fu, w.x) + 1) / 2, 0.0, 1.0),
          std::clamp((std::copysign(fv, w.y) + 1) / 2, 0.0, 1.0)};
}

V3d map_from_luminaire(const V3d& w) {
  const double* const m = kMapFromLuminaire;
  return {m[0] * w.x + m[1] * w.y + m[2] * w.z, m[3] * w.x + m[4] * w.y + m[5] * w.z,
          m[6] * w.x + m[7] * w.y + m[8] * w.z};
}

V3d luminaire_from_map(const V3d& w) {
  const double* const m = kMapFromLuminaire;
  return {m[0] * w.x + m[3] * w.y + m[6] * w.z, m[1] * w.x + m[4] * w.y + m[7] * w.z,
          m[2] * w.x + m[5] * w.y + m[8] * w.z};
}

/// One channel of a square image, rows from the top.
struct Texels {
  std::int32_t size = 0;
  std::vector<float> values;

  double at(std::int32_t x, std::int32_t y) const {
    const auto inside = [&](std::int32_t i) { return static_cast<std::size_t>(std::clamp(i, 0, size - 1)); };
    return values[inside(y) * static_cast<std::size_t>(size) + inside(x)];
  }
  /// As textures that clamp look it up between texels.
  double between(V2d uv) const {
    const double x = uv.x * size - 0.5, y = uv.y * size - 0.5;
    const double left = std::floor(x), top = std::floor(y), s = x - left, t = y - top;
    const auto i = static_cast<std::int32_t>(left), k = static_cast<std::int32_t>(top);
    return (1 - t) * ((1 - s) * at(i, k) + s * at(i + 1, k)) +
           t * ((1 - s) * at(i, k + 1) + s * at(i + 1, k + 1));
  }
};

Texels sample_intensities(const Luminaire& luminaire, std::int32_t size) {
  Texels texels{size, {}};
  texels.values.reserve(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  for (std::int32_t y = 0; y < size; ++y) {
    for (std::int32_t x = 0; x < size; ++x) {
      const V3d w = luminaire_from_map(direction_from_map({(x + 0.5) / size, (y + 0.5) / size}));
      texels.values.push_back(static_cast<float>(photometry::intensity(luminaire, w.x, w.y, w.z)));
    }
  }
  return texels;
}

V3d direction_of(PlaneSystem system, double plane_degrees, double polar_degrees) {
  const double a = plane_degrees * std::numbers::pi / 180, b = polar_degrees * std::numbers::pi / 180;
  switch (system) {
    case PlaneSystem::kC:
      return {std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b)};
    case PlaneSystem::kB:
      return {std::sin(b), std::cos(b) * std::sin(a), -std::cos(b) * std::cos(a)};
    case PlaneSystem::kA:
      break;
  }
  return {std::cos(b) * std::sin(a), std::sin(b), -std::cos(b) * std::cos(a)};
}

/// Middles between the angles of a list, at most some hundreds of them; of a list of one, that.
std::vector<double> cell_middles(const std::vector<double>& list) {
  constexpr std::size_t kMost = 256;
  if (list.size() == 1) return {0, 45};
  std::vector<double> result;
  for (std::size_t i = 0; i + 1 < list.size(); i += 1 + list.size() / kMost)
    result.push_back((list[i] + list[i + 1]) / 2);
  return result;
}

/// The largest difference between the map and the file in the middles of cells, over the intensity there or a
/// fiftieth of the largest, whichever is more.
double worst_error(const Luminaire& luminaire, const Texels& texels, double scale) {
  const double peak = std::ranges::max(luminaire.values) * luminaire.candelas_per_value();
  double worst = 0;
  for (const double plane : cell_middles(luminaire.plane_degrees)) {
    for (const double polar : cell_middles(luminaire.polar_degrees)) {
      const V3d w = direction_of(luminaire.system, plane, polar);
      const double told = photometry::intensity(luminaire, w.x, w.y, w.z);
      const double found = scale * texels.between(map_from_direction(map_from_luminaire(w)));
      worst = std::max(worst, std::abs(found - told) / std::max(told, peak / 50));
    }
  }
  return worst;
}

}  // namespace

PhotometricMap build_photometric_map(const Luminaire& luminaire) {
  constexpr std::int32_t kSmallest = 256, kLargest = 2048;
  constexpr double kTolerance = 0.003;
  PhotometricMap map;
  map.mean_candelas = photometry::flux(luminaire) / (4 * std::numbers::pi);
  Texels texels;
  double mean = 0;
  for (std::int32_t size = kSmallest; size <= kLargest; size *= 2) {
    texels = sample_intensities(luminaire, size);
    mean = 0;
    for (const float value : texels.values) mean += value;
    mean /= static_cast<double>(texels.values.size());
    if (!(mean > 0) || worst_error(luminaire, texels, map.mean_candelas / mean) <= kTolerance) break;
  }
  map.image.width = map.image.height = texels.size;
  map.image.format = TexelFormat::kFloat;
  map.image.texels32.reserve(4 * texels.values.size());
  for (const float value : texels.values) {
    const float over_mean = mean > 0 ? static_cast<float>(value / mean) : 0;
    map.image.texels32.insert(map.image.texels32.end(), {over_mean, over_mean, over_mean, 1.0f});
  }
  if (!(mean > 0)) map.mean_candelas = 0;
  return map;
}

double candelas_of_map(const PhotometricMap& map, double x, double y, double z) {
  Texels texels{map.image.width, {}};
  for (std::size_t i = 0; i < map.image.texels32.size(); i += 4)
    texels.values.push_back(map.image.texels32[i]);
  return map.mean_candelas * texels.between(map_from_direction(map_from_luminaire({x, y, z})));
}

}  // namespace tessera::render
