#include "photometry/lamps/luminaire.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "photometry/units/spelling.h"

namespace tessera::photometry {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// A place between two entries of an ascending list.
struct Between {
  std::size_t low = 0, high = 0;
  double t = 0;  // share of `high`
};

/// Nothing beyond the ends of the list, but for rounding.
bool find_between(const std::vector<double>& list, double at, Between& found) {
  constexpr double kSlack = 1e-9;
  if (!(at >= list.front() - kSlack && at <= list.back() + kSlack)) return false;
  const auto above = std::upper_bound(list.begin(), list.end(), at);
  if (above == list.begin()) {
    found = {0, 0, 0};
  } else if (above == list.end()) {
    found = {list.size() - 1, list.size() - 1, 0};
  } else {
    const auto high = static_cast<std::size_t>(above - list.begin());
    found = {high - 1, high, (at - list[high - 1]) / (list[high] - list[high - 1])};
  }
  return true;
}

/// Whether the list of C planes ends where a plane of symmetry is: it tells of the others, too.
bool is_part_of_turn(const std::vector<double>& planes) {
  const double first = planes.front(), last = planes.back();
  return planes.size() > 1 && ((first == 0 && (last == 90 || last == 180)) || (first == 90 && last == 270));
}

/// Between which C planes an angle from 0 to 360 is, by the symmetry that the list of planes tells.
Between find_c_plane(const Luminaire& l, double c) {
  const std::vector<double>& planes = l.plane_degrees;
  Between found;
  if (planes.size() == 1) return found;
  if (planes.front() == 0 && planes.back() == 90) {
    c = c > 180 ? 360 - c : c;
    c = c > 90 ? 180 - c : c;
  } else if (planes.front() == 0 && planes.back() == 180) {
    c = c > 180 ? 360 - c : c;
  } else if (planes.front() == 90 && planes.back() == 270) {
    c = c < 90 ? 180 - c : c > 270 ? 540 - c : c;
  }
  if (find_between(planes, c, found)) return found;
  // Between the last plane and the first one, a turn further on.
  const double width = planes.front() + 360 - planes.back();
  const double beyond = c >= planes.back() ? c - planes.back() : c + 360 - planes.back();
  return {planes.size() - 1, 0, width > 0 ? std::clamp(beyond / width, 0.0, 1.0) : 0};
}

/// Integral over polar angles, times their Jacobian, of the line from f0 at `a` to f1 at `b` (degrees): of
/// sine (C planes) or cosine.
double line_integral(bool sine, double a_degrees, double b_degrees, double f0, double f1) {
  const double a = a_degrees * kDegree, b = b_degrees * kDegree;
  if (!(b > a)) return 0;
  const double slope = (f1 - f0) / (b - a);
  return sine ? f0 * std::cos(a) - f1 * std::cos(b) + slope * (std::sin(b) - std::sin(a))
              : f1 * std::sin(b) - f0 * std::sin(a) + slope * (std::cos(b) - std::cos(a));
}

/// The part of one plane, up to `last` degrees.
double polar_integral(const Luminaire& l, std::size_t plane, double last) {
  const std::vector<double>& polar = l.polar_degrees;
  const bool sine = l.system == PlaneSystem::kC;
  double sum = 0;
  for (std::size_t i = 0; i + 1 < polar.size() && polar[i] < last; ++i) {
    const double f0 = l.candelas(plane, i), f1 = l.candelas(plane, i + 1);
    const double end = std::min(polar[i + 1], last);
    const double t = (end - polar[i]) / (polar[i + 1] - polar[i]);
    sum += line_integral(sine, polar[i], end, f0, f0 + t * (f1 - f0));
  }
  // Tables of A and B planes from 0 on are the same on the other side.
  return l.system != PlaneSystem::kC && polar.front() == 0 ? 2 * sum : sum;
}

double integral(const Luminaire& l, double last_polar) {
  const std::vector<double>& planes = l.plane_degrees;
  if (planes.size() == 1 && l.system == PlaneSystem::kC)
    return 2 * std::numbers::pi * polar_integral(l, 0, last_polar);
  double sum = 0, covered = 0;
  std::vector<double> of_plane;
  for (std::size_t i = 0; i < planes.size(); ++i) of_plane.push_back(polar_integral(l, i, last_polar));
  for (std::size_t i = 0; i + 1 < planes.size(); ++i) {
    const double width = planes[i + 1] - planes[i];
    sum += width * kDegree * (of_plane[i] + of_plane[i + 1]) / 2;
    covered += width;
  }
  if (l.system != PlaneSystem::kC) return planes.front() == 0 ? 2 * sum : sum;
  if (is_part_of_turn(planes)) return sum * 360 / covered;
  return sum + (360 - covered) * kDegree * (of_plane.back() + of_plane.front()) / 2;
}

}  // namespace

double Luminaire::candelas_per_value() const {
  if (is_eulumdat) {
    // cd/klm: of all lamps, or of the luminaire where photometry is absolute.
    const double lumens = eulumdat.sets.empty() ? 1000 : eulumdat.sets.front().lumens;
    return eulumdat_factor * lumens / 1000;
  }
  return multiplier * ballast_factor * lamp_ballast_factor;
}

PlaneAngles angles_of(PlaneSystem system, double x, double y, double z) {
  switch (system) {
    case PlaneSystem::kC: {
      const double c = std::atan2(y, x) / kDegree;
      return {c < 0 ? c + 360 : c, std::atan2(std::hypot(x, y), -z) / kDegree};
    }
    case PlaneSystem::kB:
      return {std::atan2(y, -z) / kDegree, std::atan2(x, std::hypot(y, z)) / kDegree};
    case PlaneSystem::kA:
      break;
  }
  return {std::atan2(x, -z) / kDegree, std::atan2(y, std::hypot(x, z)) / kDegree};
}

double intensity_at(const Luminaire& l, PlaneAngles at) {
  Between plane, polar;
  if (l.system == PlaneSystem::kC) {
    plane = find_c_plane(l, at.plane);
  } else {
    if (l.plane_degrees.front() == 0) at.plane = std::abs(at.plane);
    if (l.polar_degrees.front() == 0) at.polar = std::abs(at.polar);
    if (!find_between(l.plane_degrees, at.plane, plane)) return 0;
  }
  if (!find_between(l.polar_degrees, at.polar, polar)) return 0;
  const std::size_t n = l.polar_degrees.size();
  const auto in_plane = [&](std::size_t i) {
    return (1 - polar.t) * l.values[i * n + polar.low] + polar.t * l.values[i * n + polar.high];
  };
  return l.candelas_per_value() * ((1 - plane.t) * in_plane(plane.low) + plane.t * in_plane(plane.high));
}

double intensity(const Luminaire& luminaire, double x, double y, double z) {
  return intensity_at(luminaire, angles_of(luminaire.system, x, y, z));
}

double flux(const Luminaire& luminaire) { return integral(luminaire, 360); }

double downward_flux(const Luminaire& luminaire) { return integral(luminaire, 90); }

std::string fault_of(const Luminaire& l) {
  const auto list_fault = [](const std::vector<double>& list, const char* what, double from, double to) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (!(list[i] >= from && list[i] <= to))
        return absl::StrCat(what, " angle ", i + 1, ", ", shortest(list[i]), ", is not within ",
                            shortest(from), " and ", shortest(to), " degrees");
      if (i > 0 && !(list[i] > list[i - 1]))
        return absl::StrCat(what, " angle ", i + 1, ", ", shortest(list[i]),
                            ", is not above the one before, ", shortest(list[i - 1]));
    }
    return std::string();
  };
  const bool c = l.system == PlaneSystem::kC;
  if (l.plane_degrees.empty() || l.polar_degrees.size() < 2 || (!c && l.plane_degrees.size() < 2))
    return "a table needs two angles in a plane, and a plane (of A and B planes, two)";
  for (const std::string& fault : {list_fault(l.plane_degrees, "plane", c ? 0 : -180, c ? 360 : 180),
                                   list_fault(l.polar_degrees, "polar", c ? 0 : -90, c ? 180 : 90)}) {
    if (!fault.empty()) return fault;
  }
  if (c && l.plane_degrees.size() > 1 && !is_part_of_turn(l.plane_degrees) &&
      l.plane_degrees.back() - l.plane_degrees.front() <= 180)
    return absl::StrCat("its planes go from ", shortest(l.plane_degrees.front()), " to ",
                        shortest(l.plane_degrees.back()),
                        " degrees; 0 to 90, 0 to 180, 90 to 270 or all around was expected");
  if (l.values.size() != l.plane_degrees.size() * l.polar_degrees.size())
    return absl::StrCat("a table of ", l.plane_degrees.size(), " planes of ", l.polar_degrees.size(),
                        " angles has ", l.values.size(), " values");
  for (std::size_t i = 0; i < l.values.size(); ++i) {
    if (!(l.values[i] >= 0) || !std::isfinite(l.values[i]))
      return absl::StrCat("intensity ", i + 1, ", ", shortest(l.values[i]), ", is negative or not finite");
  }
  // Beyond that, sums are none.
  constexpr double kMostCandelas = 1e30;
  const double scale = l.candelas_per_value();
  if (!(scale >= 0) || !(scale <= kMostCandelas)) return "its multipliers are negative or too large";
  if (!(std::ranges::max(l.values) * scale <= kMostCandelas)) return "its intensities are too large";
  return "";
}

}  // namespace tessera::photometry
