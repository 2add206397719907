// The procedural cloud of pbrt-v4, and the noise that it is made of.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "import/pbrt/matter/media.h"
#include "tables/perlin.h"

namespace tessera::client::pbrt {
namespace {

double gradient(std::int64_t x, std::int64_t y, std::int64_t z, double dx, double dy, double dz) {
  const auto permuted = [](std::int64_t i) { return std::int64_t{tables::kPerlinPermutation[i & 255]}; };
  const std::int64_t h = permuted(permuted(permuted(x) + y) + z) & 15;
  const double u = h < 8 || h == 12 || h == 13 ? dx : dy;
  const double v = h < 4 || h == 12 || h == 13 ? dy : dz;
  return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

double noise(const Imath::V3d& p) {
  std::int64_t i[3];
  double d[3], w[3];
  for (std::size_t a = 0; a < 3; ++a) {
    const double cell = std::floor(std::fmod(p[a], 1073741824.0));
    i[a] = static_cast<std::int64_t>(cell);
    d[a] = std::fmod(p[a], 1073741824.0) - cell;
    w[a] = d[a] * d[a] * d[a] * (d[a] * (6 * d[a] - 15) + 10);
  }
  const auto corner = [&](int x, int y, int z) {
    return gradient(i[0] + x, i[1] + y, i[2] + z, d[0] - x, d[1] - y, d[2] - z);
  };
  const auto along_x = [&](int y, int z) { return std::lerp(corner(0, y, z), corner(1, y, z), w[0]); };
  const auto along_y = [&](int z) { return std::lerp(along_x(0, z), along_x(1, z), w[1]); };
  return std::lerp(along_y(0), along_y(1), w[2]);
}

}  // namespace

double CloudShape::at(const Imath::V3d& p) const {
  Imath::V3d q = frequency * p;
  if (wispiness > 0) {
    // The point is moved along the noise's slope, twice.
    constexpr double kStep = 0.01;
    double weight = 0.05 * wispiness, finer = 10;
    for (int octave = 0; octave < 2; ++octave) {
      const Imath::V3d at = finer * q;
      const double here = noise(at);
      Imath::V3d slope;
      for (std::size_t a = 0; a < 3; ++a) {
        Imath::V3d beside = at;
        beside[a] += kStep;
        slope[a] = (noise(beside) - here) / kStep;
      }
      for (std::size_t a = 0; a < 3; ++a) q[a] += weight * slope[a];
      weight *= 0.5;
      finer *= 1.99;
    }
  }
  double sum = 0, weight = 0.5, finer = 1;
  for (int octave = 0; octave < 5; ++octave) {
    sum += weight * noise(finer * q);
    weight *= 0.5;
    finer *= 1.99;
  }
  // Thinner with height.
  const double d = std::clamp((1 - p[1]) * 4.5 * density * sum, 0.0, 1.0);
  return std::clamp(d + 2 * std::max(0.0, 0.5 - p[1]), 0.0, 1.0);
}

}  // namespace tessera::client::pbrt
