#include "optics/prescription.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace tessera::optics {

namespace {

/// Surfaces of cemented or touching glass are published with their last digit rounded.
constexpr double kTouching = 0.02;
constexpr double kLeastIndex = 1, kMostIndex = 4.5;  // germanium's is 4
constexpr double kMostDiameter = 1e5;
// Every ray meets every surface: more of them are a file that is no lens, and would take for ever.
constexpr std::size_t kMostSurfaces = 256, kMostCoefficients = 16;

bool is_number(const Surface& s) {
  const bool finite = std::isfinite(s.radius) && std::isfinite(s.thickness) && std::isfinite(s.diameter) &&
                      std::isfinite(s.conic) && std::isfinite(s.axis_degrees);
  return finite &&
         std::all_of(s.aspheric.begin(), s.aspheric.end(), [](double a) { return std::isfinite(a); });
}

class Check {
 public:
  explicit Check(const Prescription& lens) : lens_(lens) {}

  std::vector<Fault> run() {
    if (lens_.surfaces.empty()) return {{0, 0, "a lens without surfaces"}};
    if (lens_.surfaces.size() > kMostSurfaces)
      return {
          {lens_.surfaces[kMostSurfaces].line, 0,
           absl::StrCat("a lens of ", lens_.surfaces.size(), " surfaces; ", kMostSurfaces, " are possible")}};
    for (std::size_t i = 0; i < lens_.surfaces.size(); ++i) check_surface(i);
    check_stops();
    if (!faults_.empty()) return std::move(faults_);
    for (std::size_t i = 0; i + 1 < lens_.surfaces.size(); ++i) check_gap(i);
    return std::move(faults_);
  }

 private:
  template <class... Text>
  void add(std::size_t i, const Text&... text) {
    faults_.push_back({lens_.surfaces[i].line, 0, absl::StrCat("surface ", i + 1, ": ", text...), i + 1});
  }

  void check_surface(std::size_t i) {
    const Surface& s = lens_.surfaces[i];
    if (!is_number(s)) return add(i, "its numbers are not finite");
    if (!(s.diameter > 0)) return add(i, "an aperture of ", s.diameter, " mm is not above 0");
    if (s.diameter < kLeastDiameter || s.diameter > kMostDiameter)
      return add(i, "an aperture of ", s.diameter, " mm is none of a lens, which has ", kLeastDiameter,
                 " to ", kMostDiameter, " mm");
    if (s.aspheric.size() > kMostCoefficients)
      return add(i, s.aspheric.size(), " aspheric coefficients; ", kMostCoefficients, " are possible");
    if (s.thickness < 0)
      add(i, "a thickness of ", s.thickness, " mm: the next surface would lie before this one");
    for (const double nm : {kLineD, 400.0, 700.0}) {
      const double eta = s.behind.eta(nm);
      if (eta >= kLeastIndex && eta <= kMostIndex) continue;
      add(i, "an index of refraction of ", eta, " behind it is none of a lens, which has 1 to ", kMostIndex);
      break;
    }
    if (s.coating && !(s.coating->index >= kLeastIndex && s.coating->index <= kMostIndex &&
                       s.coating->thickness_nm >= 0 && s.coating->thickness_nm <= 1e4))
      add(i, "a coating of index ", s.coating->index, " and ", s.coating->thickness_nm,
          " nm; an index from 1 and less than 10000 nm are possible");
    if (!sag(s, s.diameter / 2))
      add(i, "an aperture of ", s.diameter, " mm is larger than its element: a radius of curvature of ",
          s.radius, " mm ends at ", 2 * end_of(s), " mm");
  }

  /// Distance from the axis at which a conic ends.
  static double end_of(const Surface& s) { return std::abs(s.radius) / std::sqrt(1 + s.conic); }

  void check_stops() {
    int stops = 0;
    for (std::size_t i = 0; i < lens_.surfaces.size(); ++i) {
      if (!lens_.surfaces[i].stop) continue;
      if (++stops > 1) add(i, "a second aperture stop");
    }
    if (stops == 0) faults_.push_back({0, 0, "no surface is the aperture stop"});
  }

  /// Looks for a place at which the next surface lies before this one.
  void check_gap(std::size_t i) {
    const Surface &a = lens_.surfaces[i], &b = lens_.surfaces[i + 1];
    const double most = std::min(a.diameter, b.diameter) / 2;
    constexpr int kSteps = 64;
    for (int step = 0; step <= kSteps; ++step) {
      const double h = most * step / kSteps;
      const double gap = a.thickness + sag(b, h).value_or(0) - sag(a, h).value_or(0);
      if (gap >= -kTouching) continue;
      return add(i, "it and surface ", i + 2, " overlap: ", h, " mm from the axis the next one lies ", -gap,
                 " mm before it; a radius of the wrong sign, or surfaces in the wrong order?");
    }
  }

  const Prescription& lens_;
  std::vector<Fault> faults_;
};

}  // namespace

std::optional<double> sag(const Surface& surface, double distance) {
  const double h2 = distance * distance, c = surface.radius != 0 ? 1 / surface.radius : 0;
  const double under = 1 - (1 + surface.conic) * c * c * h2;
  if (!(under >= 0)) return std::nullopt;
  double z = c * h2 / (1 + std::sqrt(under)), power = h2;
  for (const double a : surface.aspheric) z += a * (power *= h2);
  return z;
}

std::vector<Fault> faults_of(const Prescription& lens) { return Check(lens).run(); }

}  // namespace tessera::optics
