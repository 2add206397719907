#include "photometry/sky/sky_map.h"

namespace tessera::photometry {
namespace {

constexpr int kUsualSteps = 2, kFineSteps = 8;
/// Rows across the sun's radius, the last of which is half lit.
constexpr int kSunRows = 32;

/// Points across a cell, along each of its sides.
int steps_of(const SkyPattern& pattern, const HorizonDirection& sun, int size, int x, int y) {
  // Cells are at most some 1.7 times as long as they are wide.
  const double width = 2 * std::sqrt(std::numbers::pi) / size;
  const HorizonDirection middle = direction_of_map((x + 0.5) / size, (y + 0.5) / size);
  if (std::abs(middle.up) < 1.5 * width) return kFineSteps;
  return pattern.has_indicatrix() && angle_between(middle, sun) < 3 * width ? kFineSteps : kUsualSteps;
}

/// Integrals over a cell, divided by its solid angle.
struct CellMeans {
  double sky = 0, sky_share = 0, cosine = 0;
};

CellMeans means_of(const Sky& sky, int size, int x, int y) {
  const int steps = steps_of(sky.pattern, sky.sun, size, x, y);
  CellMeans means;
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps; ++i) {
      const HorizonDirection w =
          direction_of_map((x + (i + 0.5) / steps) / size, (y + (j + 0.5) / steps) / size);
      if (!(w.up > 0)) continue;
      means.sky += relative_luminance(sky.pattern, w, sky.sun);
      means.sky_share += 1;
      means.cosine += w.up;
    }
  }
  const double points = steps * steps;
  means.sky /= points, means.sky_share /= points, means.cosine /= points;
  return means;
}

}  // namespace

HorizonDirection direction_of_map(double u, double v) {
  const double x = 2 * u - 1, y = 2 * v - 1, ax = std::abs(x), ay = std::abs(y);
  const double from_horizon = 1 - (ax + ay);  // positive above
  const double r = 1 - std::abs(from_horizon);
  const double turn = std::numbers::pi / 4 * (r == 0 ? 1 : (ay - ax) / r + 1);
  const double up = std::copysign(1 - r * r, from_horizon);
  const double sine = r * std::sqrt(std::max(2 - r * r, 0.0));
  return {sine * std::copysign(std::cos(turn), x), sine * std::copysign(std::sin(turn), y), up};
}

std::vector<float> sky_map(const Sky& sky, int size) {
  const auto cells = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  std::vector<CellMeans> means;
  means.reserve(cells);
  double lit = 0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      means.push_back(means_of(sky, size, x, y));
      lit += means.back().sky * means.back().cosine;
    }
  }
  lit *= 4 * std::numbers::pi / static_cast<double>(cells);
  const double scale = lit > 0 ? diffuse_horizontal_illuminance(sky) / lit : 0;
  std::vector<float> map;
  map.reserve(cells);
  for (const CellMeans& cell : means)
    map.push_back(static_cast<float>(cell.sky * scale + (1 - cell.sky_share) * sky.ground_luminance));
  return map;
}

SunColumn sun_column(double degrees, double normal_illuminance) {
  SunColumn column;
  const double radius = degrees / 2 * kRadiansPerDegree;
  column.lit_rows = kSunRows;
  column.rows = 1 + static_cast<int>(std::lround((kSunRows - 0.5) * std::numbers::pi / radius));
  const double step = std::numbers::pi / (column.rows - 1);
  // The illuminance is the integral of luminance cos sin over all angles, 2 pi times; by parts, that is pi
  // times the mean of sin^2 over the row along which the luminance falls. By Gauss's rule of three points:
  const double middle = (kSunRows - 0.5) * step, half = step / 2;
  const auto square = [](double angle) { return std::sin(angle) * std::sin(angle); };
  const double offset = half * std::sqrt(0.6);
  const double mean = (5 * square(middle - offset) + 8 * square(middle) + 5 * square(middle + offset)) / 18;
  column.luminance = normal_illuminance / (std::numbers::pi * mean);
  return column;
}

}  // namespace tessera::photometry
