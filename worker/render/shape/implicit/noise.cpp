#include <algorithm>
#include <cmath>
#include <cstdint>

#include "render/shape/implicit/double_functions.h"
#include "tables/perlin.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// The slope of a corner of the lattice: as in color/noise.cpp.
void corner_slope(std::uint32_t hash, double (&g)[3]) {
  const std::uint32_t h = hash & 15;
  const bool twelve = h == 12 || h == 13;
  g[0] = g[1] = g[2] = 0;
  g[h < 8 || twelve ? 0 : 1] = h & 1 ? -1 : 1;
  g[h < 4 || twelve ? 1 : 2] += h & 2 ? -1 : 1;
}

double ease(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
double ease_slope(double t) { return 30 * t * t * (t - 1) * (t - 1); }

}  // namespace

NoisePoint noise_at(const double (&p)[3]) {
  const auto& table = tables::kPerlinPermutation;
  const auto permuted = [&](std::uint32_t i) { return table[i & 255]; };
  std::uint32_t lower[3];
  double d[3], weight[3][2], slope[3][2];
  for (int a = 0; a < 3; ++a) {
    const double x = std::isfinite(p[a]) ? std::clamp(p[a], -1e15, 1e15) : 0;
    const double below = std::floor(x);
    lower[a] = static_cast<std::uint32_t>(static_cast<std::int64_t>(below) & 255);
    d[a] = x - below;
    weight[a][1] = ease(d[a]), weight[a][0] = 1 - weight[a][1];
    slope[a][1] = ease_slope(d[a]), slope[a][0] = -slope[a][1];
  }
  NoisePoint n{0, {0, 0, 0}};
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    const std::uint32_t i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    double g[3];
    corner_slope(permuted(permuted(permuted(lower[0] + i) + lower[1] + j) + lower[2] + k), g);
    const double value = g[0] * (d[0] - i) + g[1] * (d[1] - j) + g[2] * (d[2] - k);
    const double wx = weight[0][i], wy = weight[1][j], wz = weight[2][k], w = wx * wy * wz;
    n.value += w * value;
    n.gradient[0] += w * g[0] + slope[0][i] * wy * wz * value;
    n.gradient[1] += w * g[1] + wx * slope[1][j] * wz * value;
    n.gradient[2] += w * g[2] + wx * wy * slope[2][k] * value;
  }
  return n;
}

}  // namespace tessera::render::TESSERA_ISA
