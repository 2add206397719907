#include "render/bsdf/tables/film_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/bsdf/boundary_scatter.h"
#include "render/bsdf/tables/sqr.h"
#include "spectra/rgb/scene_rgb.h"

namespace tessera::render {

namespace {

void put_interference(float* table) {
  const std::vector<spectra::ReflectanceShare> shares = spectra::reflectance_shares();
  for (std::size_t i = 0; i + 1 < kFilmEntries; ++i) {
    double sums[3] = {0, 0, 0};
    for (const spectra::ReflectanceShare& share : shares) {
      const double wave =
          std::cos(2 * std::numbers::pi * static_cast<double>(i) * double{kFilmStepNm} / share.nm);
      for (std::size_t c = 0; c < 3; ++c) sums[c] += share.rgb[c] * wave;
    }
    for (std::size_t c = 0; c < 3; ++c) table[i * kFilmEntry + c] = static_cast<float>(sums[c]);
  }
}

/// Two cosines that have the first four moments of all [Golub & Welsch 1969].
void put_facets(double roughness, double cosine, float* entry) {
  static const HalfDisk disk(987, 610);
  const double z = std::clamp(cosine, 1e-6, 1.0), sine = std::sqrt(1 - sqr(z));
  const double alpha = std::max(sqr(roughness), double{kLeastLayerAlpha});
  std::vector<double> weights, cosines;
  double all = 0, mean = 0;
  scatter_once(sine, 0, z, {alpha, alpha}, 0, disk.points, false,
               [&](double x, double y, double up, double part) {
                 const double half = std::sqrt(sqr(sine + x) + sqr(y) + sqr(z + up)) / 2;
                 weights.push_back(part * (1 - std::pow(std::max(1 - half, 0.0), 5)));
                 cosines.push_back(half);
                 all += weights.back(), mean += weights.back() * half;
               });
  mean /= std::max(all, 1e-12);
  double variance = 0, third = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double off = cosines[i] - mean;
    variance += weights[i] * sqr(off), third += weights[i] * sqr(off) * off;
  }
  variance /= std::max(all, 1e-12), third /= std::max(all, 1e-12);
  const double deviation = std::sqrt(variance), skew = third / std::max(variance * deviation, 1e-18) / 2;
  const double reach = std::sqrt(1 + sqr(skew));
  entry[0] = static_cast<float>(std::clamp(mean + deviation * (skew - reach), 0.0, 1.0));
  entry[1] = static_cast<float>(std::clamp(mean + deviation * (skew + reach), 0.0, 1.0));
  entry[2] = static_cast<float>((1 + skew / reach) / 2);
}

}  // namespace

std::vector<float> film_table() {
  std::vector<float> table(std::size_t{kFacetCosines} + std::size_t{kFilmEntry} * kLayerRows * kLayerColumns,
                           0.0f);
  put_interference(table.data());
  float* entry = table.data() + kFacetCosines;
  for (int r = 0; r < kLayerRows; ++r) {
    for (int c = 0; c < kLayerColumns; ++c, entry += kFilmEntry)
      put_facets(r / (kLayerRows - 1.0), sqr(c / (kLayerColumns - 1.0)), entry);
  }
  return table;
}

}  // namespace tessera::render
