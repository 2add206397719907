#include "photometry/glare/glare_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "absl/status/status.h"

namespace tessera::photometry {
namespace {

/// Sum over sources of luminance^2 times solid angle over position index^2.
double glare_sum(std::span<const GlareSource> sources) {
  double sum = 0;
  for (const GlareSource& s : sources)
    sum += s.luminance * s.luminance * s.solid_angle / (s.position_index * s.position_index);
  return sum;
}

double light_at_eye(const LuminancePicture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.size(); ++i)
    sum += picture.luminances[i] * picture.solid_angles[i] * std::max(picture.directions[i].forward, 0.0);
  return sum;
}

}  // namespace

double unified_glare_rating(std::span<const GlareSource> sources, double background_luminance) {
  return 8 * std::log10(0.25 / background_luminance * glare_sum(sources));
}

double daylight_glare_probability(std::span<const GlareSource> sources, double vertical_illuminance,
                                  bool low_light_correction) {
  const double e = vertical_illuminance;
  const double contrast = e > 0 ? std::log10(1 + glare_sum(sources) / std::pow(e, 1.87)) : 0;
  double probability = 5.87e-5 * e + 9.18e-2 * contrast + 0.16;
  if (low_light_correction) {
    // The ratio of exp(x) to 1 + exp(x), which has no infinite parts.
    probability *= 1 / (1 + std::exp(4 - 0.024 * e));
  }
  return std::min(probability, 1.0);
}

double daylight_glare_index(std::span<const GlareSource> sources, double background_luminance) {
  double sum = 0;
  for (const GlareSource& s : sources) {
    const double seen = s.solid_angle / (s.position_index * s.position_index);
    sum += 0.478 * std::pow(s.luminance, 1.6) * std::pow(seen, 0.8) /
           (background_luminance + 0.07 * std::sqrt(s.solid_angle) * s.luminance);
  }
  return 10 * std::log10(sum);
}

absl::StatusOr<GlareFigures> glare_of(const LuminancePicture& picture, const GlareOptions& options) {
  if (auto s = check_picture(picture); !s.ok()) return s;
  const SourceSearch& search = options.search;
  for (const double value : {search.threshold, search.factor, search.search_radius,
                             search.task.radius_degrees, options.vertical_illuminance}) {
    if (!(value >= 0 && std::isfinite(value)))
      return absl::InvalidArgumentError("a threshold, radius or illuminance is negative or not finite");
  }
  GlareFigures figures;
  figures.found = find_glare_sources(picture, search);
  figures.mean_luminance = mean_luminance(picture);
  figures.vertical_illuminance =
      options.vertical_illuminance > 0 ? options.vertical_illuminance : light_at_eye(picture);
  double of_sources = 0;
  for (const GlareSource& source : figures.found.sources) of_sources += source.illuminance;
  figures.background_luminance = std::max(figures.vertical_illuminance - of_sources, 0.0) / std::numbers::pi;
  figures.daylight_glare_probability = daylight_glare_probability(
      figures.found.sources, figures.vertical_illuminance, options.low_light_correction);
  if (figures.found.sources.empty()) {
    figures.unified_glare_rating = figures.daylight_glare_index = -std::numeric_limits<double>::infinity();
  } else {
    figures.unified_glare_rating = unified_glare_rating(figures.found.sources, figures.background_luminance);
    figures.daylight_glare_index = daylight_glare_index(figures.found.sources, figures.background_luminance);
  }
  return figures;
}

}  // namespace tessera::photometry
