// Light scattered once by a rough boundary, by quadrature in double precision: for the tables that are made
// when a scene is loaded. The microfacets are those of microfacet.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tessera::render {

/// Points of half the unit disk (the other half mirrors it) with weights that sum to 1: a Fibonacci lattice
/// [Sloan & Joe 1994], drawn towards centre and rim by a smooth change of variable.
struct HalfDisk {
  struct Point {
    double radius2, cosine, sine, weight;
  };
  std::vector<Point> points;

  /// Two neighbours of Fibonacci's sequence.
  HalfDisk(int count, int generator) {
    const double sum = count + 0.5 / count;  // sum of 6 x (1 - x) over the midpoints x
    for (int i = 0; i < count; ++i) {
      const double x = (i + 0.5) / count;
      const double phi = std::numbers::pi * (static_cast<long>(i) * generator % count + 0.5) / count;
      points.push_back({x * x * (3 - 2 * x), std::cos(phi), std::sin(phi), 6 * x * (1 - x) / sum});
    }
  }
};

/// Fresnel reflectance of a dielectric; `g` becomes eta times the cosine of refraction, as in fresnel.h.
inline double dielectric_reflectance(double cosine, double eta, double& g) {
  const double g2 = (eta - 1) * (eta + 1) + cosine * cosine;
  g = std::sqrt(std::max(g2, 0.0));
  if (g2 <= 0) return 1;
  const double eta2_cosine = eta * eta * cosine;
  const double parallel = (eta2_cosine - g) / (eta2_cosine + g), perpendicular = (cosine - g) / (cosine + g);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

/// Microfacets of two roughnesses > 0, along x and y.
struct ScatteringFacets {
  double alpha_x, alpha_y;
  bool beckmann = false;
  bool separable_masking = false;

  /// Squared length of the tangential part of a direction, stretched.
  double stretched2(double x, double y) const {
    return alpha_x * alpha_x * x * x + alpha_y * alpha_y * y * y;
  }
  /// The masking lengths of Microfacets.
  double ggx_length(double x, double y, double z) const { return std::sqrt(stretched2(x, y) + z * z); }
  double masking_length(double x, double y, double z) const {
    if (!beckmann) return ggx_length(x, y, z);
    const double slope = std::sqrt(stretched2(x, y));
    if (z >= 1.6 * slope) return z;
    const double a = z / slope;
    return 2 * slope * (1 + 2.276 * a + 2.577 * a * a) / (3.535 + 2.181 * a) - z;
  }
  double masking_pair(double so, double zo, double si, double zi) const {
    return separable_masking ? 0.5 * (zo + so) * (zi + si) : so * zi + si * zo;
  }
};

/// Calls visit(x, y, z, energy) for directions into which light along the unit vector (ox, oy, oz), oz > 0,
/// is scattered, with the part of its energy that goes there. `eta` is the index of the other side over that
/// of the light's side, 0 for a perfect mirror. `points` are of the half y > 0 of the disk of visible
/// normals; `mirrored` takes the other half too, which is superfluous for oy = 0.
///
/// Quadrature over the cap of normals that are visible if they are distributed as GGX, see
/// Microfacets::sample_visible; Beckmann's are weighted by the ratio of the densities, at most 4 / e. Each
/// normal scatters with G2 / G1. Where light leaves the right side or is totally reflected the integrand has
/// edges: a lattice does better there than Gauss points.
template <class Visit>
void scatter_once(double ox, double oy, double oz, const ScatteringFacets& facets, double eta,
                  const std::vector<HalfDisk::Point>& points, bool mirrored, Visit&& visit) {
  const double ggx_so = facets.ggx_length(ox, oy, oz), so = facets.masking_length(ox, oy, oz);
  const double wx = facets.alpha_x * ox / ggx_so, wy = facets.alpha_y * oy / ggx_so, height = 1 + oz / ggx_so;
  const auto visible_weight = [&](double x, double y, double z) {
    return z * (oz + so) / facets.masking_pair(so, oz, facets.masking_length(x, y, z), z);
  };
  const auto scatter = [&](double hx, double hy, double hz, double weight) {
    double mx = facets.alpha_x * hx, my = facets.alpha_y * hy, mz = hz;
    const double length = std::sqrt(mx * mx + my * my + mz * mz);
    mx /= length, my /= length, mz /= length;
    if (facets.beckmann) {
      // Beckmann's density over that of GGX, for this squared slope in units of alpha.
      const double slope2 = (hx * hx + hy * hy) / (hz * hz);
      weight *= std::exp(-slope2) * (1 + slope2) * (1 + slope2) * (oz + ggx_so) / (oz + so);
    }
    const double cos_m = ox * mx + oy * my + oz * mz;
    double g = 0;
    const double f = eta > 0 ? dielectric_reflectance(cos_m, eta, g) : 1.0;
    const double reflected_z = 2 * cos_m * mz - oz;
    if (reflected_z > 0) {
      const double x = 2 * cos_m * mx - ox, y = 2 * cos_m * my - oy;
      visit(x, y, reflected_z, weight * f * visible_weight(x, y, reflected_z));
    }
    if (f >= 1) return;
    const double x = ((cos_m - g) * mx - ox) / eta, y = ((cos_m - g) * my - oy) / eta;
    const double z = ((cos_m - g) * mz - oz) / eta;
    if (z < 0) visit(x, y, z, weight * (1 - f) * visible_weight(x, y, -z));
  };
  for (const HalfDisk::Point& point : points) {
    const double depth = point.radius2 * height, scale = std::sqrt(point.radius2 * height * (2 - depth));
    const double px = point.cosine * scale + wx, py = point.sine * scale, pz = 1 - depth + oz / ggx_so;
    scatter(px, py + wy, pz, mirrored ? 0.5 * point.weight : point.weight);
    if (mirrored) scatter(px, wy - py, pz, 0.5 * point.weight);
  }
}

}  // namespace tessera::render
