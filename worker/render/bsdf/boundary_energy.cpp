#include "render/bsdf/boundary_energy.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tessera::render {

namespace {

double sqr(double x) { return x * x; }

/// Fresnel reflectance; `g` becomes eta times the cosine of refraction, as in fresnel.h.
double fresnel(double cosine, double eta, double& g) {
  const double g2 = (eta - 1) * (eta + 1) + sqr(cosine);
  g = std::sqrt(std::max(g2, 0.0));
  if (g2 <= 0) return 1;
  const double eta2_cosine = sqr(eta) * cosine;
  return 0.5 * (sqr((eta2_cosine - g) / (eta2_cosine + g)) + sqr((cosine - g) / (cosine + g)));
}

/// Points of half the unit disk (the other half mirrors it) with weights that sum to 1: a Fibonacci lattice
/// [Sloan & Joe 1994], drawn towards centre and rim by a smooth change of variable.
struct HalfDisk {
  struct Point {
    double radius2, cosine, sine, weight;
  };
  std::vector<Point> points;

  /// Two neighbours of Fibonacci's sequence.
  HalfDisk(int count, int generator) {
    const double sum = count + 0.5 / count;  // of 6 x (1 - x) over the midpoints x
    for (int i = 0; i < count; ++i) {
      const double x = (i + 0.5) / count;
      const double phi = std::numbers::pi * (static_cast<long>(i) * generator % count + 0.5) / count;
      points.push_back({x * x * (3 - 2 * x), std::cos(phi), std::sin(phi), 6 * x * (1 - x) / sum});
    }
  }
};

const HalfDisk& half_disk(Quadrature quadrature) {
  static const HalfDisk coarse(377, 233), fine(4181, 2584);
  return quadrature == Quadrature::kFine ? fine : coarse;
}

/// The masking lengths of Microfacets (microfacet.h), of directions with these components.
double ggx_length(double alpha, double tangential2, double z) { return std::sqrt(sqr(alpha) * tangential2 + sqr(z)); }
double beckmann_length(double alpha, double tangential2, double z) {
  const double slope = alpha * std::sqrt(tangential2);
  if (z >= 1.6 * slope) return z;
  const double a = z / slope;
  return 2 * slope * (1 + 2.276 * a + 2.577 * a * a) / (3.535 + 2.181 * a) - z;
}

/// Beckmann's density over that of GGX, for a slope of squared length `slope2` in units of alpha.
double beckmann_over_ggx(double slope2) { return std::exp(-slope2) * sqr(1 + slope2); }

}  // namespace

BoundaryEnergy boundary_energy(double cosine, const BoundaryFacets& facets, double eta, Quadrature quadrature) {
  BoundaryEnergy energy;
  double g = 0;
  if (facets.alpha == 0) {
    energy.reflected = fresnel(cosine, eta, g);
    energy.transmitted = 1 - energy.reflected;
    return energy;
  }
  // Quadrature over the cap of normals that are visible if they are distributed as GGX, see
  // Microfacets::sample_visible; Beckmann's are weighted by the ratio of the densities, at most 4 / e. Each normal
  // scatters with G2 / G1. Where light leaves the right side or is totally reflected the integrand has edges: a lattice
  // does better there than Gauss points.
  const double alpha = facets.alpha, sine = std::sqrt(std::max(0.0, 1 - sqr(cosine)));
  const auto masking_length = facets.beckmann ? beckmann_length : ggx_length;
  const double ggx_so = ggx_length(alpha, sqr(sine), cosine), so = masking_length(alpha, sqr(sine), cosine);
  const double wx = alpha * sine / ggx_so, wz = cosine / ggx_so, height = 1 + wz;
  const auto visible_weight = [&](double x, double y, double z) {
    const double si = masking_length(alpha, sqr(x) + sqr(y), z);
    const double pair = facets.separable_masking ? 0.5 * (cosine + so) * (z + si) : so * z + si * cosine;
    return z * (cosine + so) / pair;
  };
  for (const HalfDisk::Point& point : half_disk(quadrature).points) {
    const double depth = point.radius2 * height, scale = std::sqrt(point.radius2 * height * (2 - depth));
    double mx = alpha * (point.cosine * scale + wx), my = alpha * point.sine * scale, mz = 1 - depth + wz;
    const double length = std::sqrt(sqr(mx) + sqr(my) + sqr(mz));
    mx /= length, my /= length, mz /= length;
    double weight = point.weight;
    if (facets.beckmann) {
      weight *= beckmann_over_ggx((sqr(mx) + sqr(my)) / sqr(alpha * mz)) * (cosine + ggx_so) / (cosine + so);
    }
    const double cos_m = sine * mx + cosine * mz;
    const double f = fresnel(cos_m, eta, g);
    const double reflected_z = 2 * cos_m * mz - cosine;
    if (reflected_z > 0) {
      energy.reflected += weight * f * visible_weight(2 * cos_m * mx - sine, 2 * cos_m * my, reflected_z);
    }
    const double refracted_z = ((cos_m - g) * mz - cosine) / eta;
    if (f < 1 && refracted_z < 0) {
      energy.transmitted +=
          weight * (1 - f) * visible_weight(((cos_m - g) * mx - sine) / eta, (cos_m - g) * my / eta, -refracted_z);
    }
  }
  return energy;
}

}  // namespace tessera::render
