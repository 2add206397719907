#include "render/bsdf/coat_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

double sqr(double x) { return x * x; }

/// Fresnel reflectance; `g` becomes eta times the cosine of refraction, as in fresnel.h.
double fresnel(double cosine, double eta, double& g) {
  const double g2 = (eta - 1) * (eta + 1) + sqr(cosine);
  g = std::sqrt(std::max(g2, 0.0));
  if (g2 <= 0) return 1;
  const double eta2_cosine = sqr(eta) * cosine;
  return 0.5 * (sqr((eta2_cosine - g) / (eta2_cosine + g)) + sqr((cosine - g) / (cosine + g)));
}

/// Integral of 2 c reflected(c) over c in [a, b]: the share of diffuse light within those cosines that is reflected.
template <class F>
double diffuse_share(double a, double b, F&& reflected) {
  static const Gauss<12> gauss;
  double sum = 0;
  for (int i = 0; i < 12; ++i) {
    const double c = a + (b - a) * gauss.x[i];
    sum += gauss.weight[i] * 2 * c * reflected(c);
  }
  return sum * (b - a);
}

/// R_int of a coat: reflectance for diffuse light from its inside.
double internal_reflectance(double alpha, double eta) {
  const auto reflected = [&](double c) { return boundary_energy(c, alpha, 1 / eta).reflected; };
  // Within the critical angle and beyond it.
  const double critical = eta > 1 ? std::sqrt((1 - 1 / eta) * (1 + 1 / eta)) : 0.0;
  return diffuse_share(critical, 1, reflected) + diffuse_share(0, critical, reflected);
}

}  // namespace

BoundaryEnergy boundary_energy(double cosine, double alpha, double eta) {
  BoundaryEnergy energy;
  double g = 0;
  if (alpha == 0) {
    energy.reflected = fresnel(cosine, eta, g);
    energy.transmitted = 1 - energy.reflected;
    return energy;
  }
  // Quadrature over the cap of visible normals, see Ggx::sample_visible in microfacet.h, in polar coordinates of its
  // disk; by symmetry half a turn is enough. Each normal scatters with G2 / G1.
  static const Gauss<12> radii;
  constexpr int kAngles = 8;
  const double sine = std::sqrt(std::max(0.0, 1 - sqr(cosine)));
  const double so = std::sqrt(sqr(alpha * sine) + sqr(cosine));
  const double wx = alpha * sine / so, wz = cosine / so, height = 1 + wz;
  const auto visible_weight = [&](double x, double y, double z) {
    const double si = std::sqrt(sqr(alpha) * (sqr(x) + sqr(y)) + sqr(z));
    return z * (cosine + so) / (so * z + si * cosine);
  };
  for (int i = 0; i < 12; ++i) {
    const double r = radii.x[i], depth = sqr(r) * height, scale = r * std::sqrt(height * (2 - depth));
    const double hz = 1 - depth + wz;
    for (int j = 0; j < kAngles; ++j) {
      const double phi = std::numbers::pi * (j + 0.5) / kAngles;
      double mx = alpha * (std::cos(phi) * scale + wx), my = alpha * std::sin(phi) * scale, mz = hz;
      const double length = std::sqrt(sqr(mx) + sqr(my) + sqr(mz));
      mx /= length, my /= length, mz /= length;
      const double cos_m = sine * mx + cosine * mz;
      const double f = fresnel(cos_m, eta, g);
      const double weight = radii.weight[i] * 2 * r / kAngles;
      const double reflected_z = 2 * cos_m * mz - cosine;
      if (reflected_z > 0) {
        energy.reflected += weight * f * visible_weight(2 * cos_m * mx - sine, 2 * cos_m * my, reflected_z);
      }
      const double refracted_z = ((cos_m - g) * mz - cosine) / eta;
      if (f < 1 && refracted_z < 0) {
        energy.transmitted += weight * (1 - f) * visible_weight(((cos_m - g) * mx - sine) / eta,
                                                                (cos_m - g) * my / eta, -refracted_z);
      }
    }
  }
  return energy;
}

std::int32_t append_coat_table(float eta, MaterialTable& table) {
  std::vector<float>& tables = table.coat_tables;
  for (std::size_t offset = 0; offset < tables.size(); offset += kCoatTableSize) {
    if (tables[offset + kCoatEta] == eta) return static_cast<std::int32_t>(offset);
  }
  const std::size_t offset = tables.size();
  tables.resize(offset + kCoatTableSize);
  float* out = tables.data() + offset;
  out[kCoatEta] = eta;
  for (int a = 0; a < kCoatAlphas; ++a) {
    const double alpha = sqr(a / (kCoatAlphas - 1.0));
    out[kCoatInternal + a] = static_cast<float>(internal_reflectance(alpha, eta));
    for (int c = 0; c < kCoatCosines; ++c) {
      // Straight along the surface nothing is defined; the limit is.
      const double cosine = std::max(sqr(c / (kCoatCosines - 1.0)), 1e-9);
      out[kCoatTransmittance + a * kCoatCosines + c] =
          static_cast<float>(boundary_energy(cosine, alpha, eta).transmitted);
    }
  }
  return static_cast<std::int32_t>(offset);
}

}  // namespace tessera::render
