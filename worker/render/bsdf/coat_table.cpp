#include "render/bsdf/coat_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

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
    if (critical > 0) beyond += gauss.weight[i] * 2 * low * part(boundary_energy(low, alpha, eta));
    within += gauss.weight[i] * 2 * gauss.x[i] * 2 * high * part(boundary_energy(high, alpha, eta));
  }
  return critical * beyond + (1 - critical) * within;
}

/// R_int of a coat: the part of diffuse light from its inside that it reflects.
double internal_reflectance(double alpha, double eta) {
  if (eta < 1) return diffuse_mean(alpha, 1 / eta, [](BoundaryEnergy e) { return e.reflected; });
  // Total reflection makes that integrand rough, and interreflection magnifies its error. By reciprocity what is let
  // through is known from outside, where all is smooth; what single scattering loses is small where edges are sharp.
  const double transmitted = diffuse_mean(alpha, eta, [](BoundaryEnergy e) { return e.transmitted; }) / sqr(eta);
  return 1 - transmitted -
         diffuse_mean(alpha, 1 / eta, [](BoundaryEnergy e) { return 1 - e.reflected - e.transmitted; });
}

/// Points of half the unit disk (the other half mirrors it) with weights that sum to 1: a Fibonacci lattice
/// [Sloan & Joe 1994], drawn towards centre and rim by a smooth change of variable.
struct HalfDisk {
  static constexpr int kPoints = 377, kGenerator = 233;
  struct Point {
    double radius2, cosine, sine, weight;
  };
  std::array<Point, kPoints> points;

  HalfDisk() {
    constexpr double kSum = kPoints + 0.5 / kPoints;  // of 6 x (1 - x) over the midpoints x
    for (int i = 0; i < kPoints; ++i) {
      const double x = (i + 0.5) / kPoints, phi = std::numbers::pi * (i * kGenerator % kPoints + 0.5) / kPoints;
      points[i] = {x * x * (3 - 2 * x), std::cos(phi), std::sin(phi), 6 * x * (1 - x) / kSum};
    }
  }
};

}  // namespace

BoundaryEnergy boundary_energy(double cosine, double alpha, double eta) {
  BoundaryEnergy energy;
  double g = 0;
  if (alpha == 0) {
    energy.reflected = fresnel(cosine, eta, g);
    energy.transmitted = 1 - energy.reflected;
    return energy;
  }
  // Quadrature over the cap of visible normals, see Ggx::sample_visible in microfacet.h. Each normal scatters with
  // G2 / G1. Where light leaves the right side or is totally reflected the integrand has edges: a lattice does better
  // there than Gauss points.
  static const HalfDisk half_disk;
  const double sine = std::sqrt(std::max(0.0, 1 - sqr(cosine)));
  const double so = std::sqrt(sqr(alpha * sine) + sqr(cosine));
  const double wx = alpha * sine / so, wz = cosine / so, height = 1 + wz;
  const auto visible_weight = [&](double x, double y, double z) {
    const double si = std::sqrt(sqr(alpha) * (sqr(x) + sqr(y)) + sqr(z));
    return z * (cosine + so) / (so * z + si * cosine);
  };
  for (const HalfDisk::Point& point : half_disk.points) {
    const double depth = point.radius2 * height, scale = std::sqrt(point.radius2 * height * (2 - depth));
    double mx = alpha * (point.cosine * scale + wx), my = alpha * point.sine * scale, mz = 1 - depth + wz;
    const double length = std::sqrt(sqr(mx) + sqr(my) + sqr(mz));
    mx /= length, my /= length, mz /= length;
    const double cos_m = sine * mx + cosine * mz;
    const double f = fresnel(cos_m, eta, g);
    const double reflected_z = 2 * cos_m * mz - cosine;
    if (reflected_z > 0) {
      energy.reflected += point.weight * f * visible_weight(2 * cos_m * mx - sine, 2 * cos_m * my, reflected_z);
    }
    const double refracted_z = ((cos_m - g) * mz - cosine) / eta;
    if (f < 1 && refracted_z < 0) {
      energy.transmitted += point.weight * (1 - f) *
                            visible_weight(((cos_m - g) * mx - sine) / eta, (cos_m - g) * my / eta, -refracted_z);
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
