#include "render/bsdf/tables/coat_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/bsdf/tables/boundary_energy.h"
#include "render/bsdf/tables/sqr.h"

namespace tessera::render {

namespace {

/// Gauss-Legendre quadrature on [0, 1]; roots of the Legendre polynomial by Newton's method.
template <int kPoints>
struct Gauss {
  std::array<double, kPoints> x, weight;

  Gauss() {
    for (int i = 0; i < kPoints; ++i) {
      double root = std::cos(std::numbers::pi * (i + 0.75) / (kPoints + 0.5)), slope = 1;
      for (int step = 0; step < 10; ++step) {
        double p = 1, previous = 0;
        for (int k = 0; k < kPoints; ++k) {
          const double before = previous;
          previous = p;
          p = ((2 * k + 1) * root * previous - k * before) / (k + 1);
        }
        slope = kPoints * (root * p - previous) / (root * root - 1);
        root -= p / slope;
      }
      x[i] = 0.5 * (1 - root);
      weight[i] = 1 / ((1 - root * root) * slope * slope);
    }
  }
};

/// Integral of 2 c part(energy at c) over the cosines c of a hemisphere: the mean over diffuse light.
template <class F>
double diffuse_mean(double alpha, double eta, F&& part) {
  constexpr int kPoints = 12;
  static const Gauss<kPoints> gauss;
  // Beyond the critical angle, if there is one, and within it, where the integrand begins like a square root.
  const double critical = eta < 1 ? std::sqrt((1 - eta) * (1 + eta)) : 0.0;
  double beyond = 0, within = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double low = critical * gauss.x[i], high = critical + (1 - critical) * sqr(gauss.x[i]);
    if (critical > 0) beyond += gauss.weight[i] * 2 * low * part(boundary_energy(low, {alpha}, eta));
    within += gauss.weight[i] * 2 * gauss.x[i] * 2 * high * part(boundary_energy(high, {alpha}, eta));
  }
  return critical * beyond + (1 - critical) * within;
}

/// R_int of a coat: the part of diffuse light from its inside that it reflects.
double internal_reflectance(double alpha, double eta) {
  if (eta < 1) return diffuse_mean(alpha, 1 / eta, [](BoundaryEnergy e) { return e.reflected; });
  // Total reflection makes that integrand rough, and interreflection magnifies its error. By reciprocity what
  // is let through is known from outside, where all is smooth; what single scattering loses is small where
  // edges are sharp.
  const double transmitted =
      diffuse_mean(alpha, eta, [](BoundaryEnergy e) { return e.transmitted; }) / sqr(eta);
  return 1 - transmitted -
         diffuse_mean(alpha, 1 / eta, [](BoundaryEnergy e) { return 1 - e.reflected - e.transmitted; });
}

/// By how much absorption on the way up and down again takes from R_int, as far as it is known of a smooth
/// coat.
double internal_attenuation(double eta, double thickness) {
  if (thickness <= 0) return 1;
  constexpr int kSteps = 2048;
  double whole = 0, left = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = (i + 0.5) / kSteps;
    const double reflected = cosine * boundary_energy(cosine, {0.0}, 1 / eta).reflected;
    whole += reflected;
    left += reflected * std::exp(-2 * thickness / cosine);
  }
  return whole > 0 ? left / whole : 1;
}

/// Part of the light that the coat let in along `cosine` that is left at the base.
double attenuation(double cosine, double eta, double thickness) {
  const double inside2 = 1 - (1 - sqr(cosine)) / sqr(eta);
  return inside2 > 0 ? std::exp(-thickness / std::sqrt(inside2)) : 0;
}

}  // namespace

std::int32_t append_coat_table(float eta, float thickness, MaterialTable& table) {
  std::vector<float>& tables = table.coat_tables;
  for (const std::int32_t offset : table.coat_offsets) {
    const float* known = tables.data() + offset;
    if (known[kCoatEta] == eta && known[kCoatThickness] == thickness) return offset;
  }
  const std::size_t offset = tables.size();
  tables.resize(offset + kCoatTableSize);
  table.coat_offsets.push_back(static_cast<std::int32_t>(offset));
  float* out = tables.data() + offset;
  out[kCoatEta] = eta;
  out[kCoatThickness] = thickness;
  const double kept_inside = internal_attenuation(eta, thickness);
  for (int a = 0; a < kCoatAlphas; ++a) {
    const double alpha = sqr(a / (kCoatAlphas - 1.0));
    out[kCoatInternal + a] = static_cast<float>(internal_reflectance(alpha, eta) * kept_inside);
    for (int c = 0; c < kCoatCosines; ++c) {
      // Straight along the surface nothing is defined; the limit is.
      const double cosine = std::max(sqr(c / (kCoatCosines - 1.0)), 1e-9);
      out[kCoatTransmittance + a * kCoatCosines + c] = static_cast<float>(
          boundary_energy(cosine, {alpha}, eta).transmitted * attenuation(cosine, eta, thickness));
    }
  }
  return static_cast<std::int32_t>(offset);
}

}  // namespace tessera::render
