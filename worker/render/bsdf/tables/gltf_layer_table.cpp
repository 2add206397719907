#include "render/bsdf/tables/gltf_layer_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/bsdf/boundary_scatter.h"
#include "render/bsdf/tables/sqr.h"

namespace tessera::render {

namespace {

struct LayerEnergy {
  double normal = 0, grazing = 0, sheen = 0;
};

/// The two parts of GGX with Schlick's reflectance.
void add_facets(double sine, double cosine, double alpha, LayerEnergy& energy) {
  static const HalfDisk disk(1597, 987);
  scatter_once(sine, 0, cosine, {alpha, alpha}, 0, disk.points, false,
               [&](double x, double y, double z, double part) {
                 const double half = std::sqrt(sqr(sine + x) + sqr(y) + sqr(cosine + z)) / 2;
                 const double weight = std::pow(std::max(1 - half, 0.0), 5);
                 energy.normal += part * (1 - weight);
                 energy.grazing += part * weight;
               });
}

/// Midpoints over the hemisphere, closer along the surface, where the lobe is [Estevez & Kulla 2017]. Above 1
/// for light along the surface.
double sheen_energy(double sine, double cosine, double alpha) {
  constexpr int kRings = 32, kSpokes = 32;
  double sum = 0;
  for (int i = 0; i < kRings; ++i) {
    const double t = (i + 0.5) / kRings, zi = sqr(t), si = std::sqrt(1 - sqr(zi));
    double ring = 0;
    for (int k = 0; k < kSpokes; ++k) {
      const double phi = std::numbers::pi * (k + 0.5) / kSpokes;
      const double hx = sine + si * std::cos(phi), hy = si * std::sin(phi), hz = cosine + zi;
      const double sin2 = (sqr(hx) + sqr(hy)) / (sqr(hx) + sqr(hy) + sqr(hz));
      ring += (2 + 1 / alpha) * std::pow(sin2, 0.5 / alpha) / (2 * std::numbers::pi);
    }
    sum += ring / kSpokes * zi / (4 * (cosine + zi - cosine * zi)) * 2 * t;
  }
  return sum / kRings * 2 * std::numbers::pi;
}

LayerEnergy energy_at(double roughness, double cosine) {
  const double z = std::clamp(cosine, 1e-6, 1.0), sine = std::sqrt(1 - sqr(z));
  LayerEnergy energy;
  add_facets(sine, z, std::max(sqr(roughness), double{kLeastLayerAlpha}), energy);
  energy.sheen = sheen_energy(sine, z, sqr(std::max(roughness, double{kLeastSheenRoughness})));
  return energy;
}

/// Over diffuse light, of what linear interpolation makes of a row: the integral of f 2 z dz, where z = x^2.
double mean_of_row(const std::vector<LayerEnergy>& row, double LayerEnergy::*part) {
  constexpr int kSteps = 16;
  double sum = 0, all = 0;
  for (int c = 0; c + 1 < kLayerColumns; ++c) {
    for (int i = 0; i < kSteps; ++i) {
      const double t = (i + 0.5) / kSteps, x = c + t, weight = x * x * x;
      const auto at = static_cast<std::size_t>(c);
      sum += weight * ((1 - t) * row[at].*part + t * row[at + 1].*part);
      all += weight;
    }
  }
  return sum / all;
}

}  // namespace

std::int32_t append_layer_table(MaterialTable& table) {
  const std::size_t offset = table.coat_tables.size();
  table.coat_tables.resize(offset + std::size_t{kLayerEntry} * kLayerRows * (1 + kLayerColumns), 0.0f);
  const auto put = [&](int entry, const LayerEnergy& energy) {
    float* out = table.coat_tables.data() + offset + static_cast<std::size_t>(entry) * kLayerEntry;
    out[0] = static_cast<float>(energy.normal);
    out[1] = static_cast<float>(energy.grazing);
    out[2] = static_cast<float>(energy.sheen);
  };
  std::vector<LayerEnergy> row(kLayerColumns);
  for (int r = 0; r < kLayerRows; ++r) {
    for (int c = 0; c < kLayerColumns; ++c) {
      row[static_cast<std::size_t>(c)] = energy_at(r / (kLayerRows - 1.0), sqr(c / (kLayerColumns - 1.0)));
      put(kLayerRows + r * kLayerColumns + c, row[static_cast<std::size_t>(c)]);
    }
    put(r, {mean_of_row(row, &LayerEnergy::normal), mean_of_row(row, &LayerEnergy::grazing),
            mean_of_row(row, &LayerEnergy::sheen)});
  }
  return static_cast<std::int32_t>(offset);
}

}  // namespace tessera::render
