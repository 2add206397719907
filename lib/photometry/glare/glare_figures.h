// Figures of discomfort glare.
#pragma once

#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "photometry/glare/glare_sources.h"

namespace tessera::photometry {

struct GlareOptions {
  SourceSearch search = {};
  /// Lowers DGP where the eye gets less than some 300 lx, for which it is not fitted [Wienold2012].
  bool low_light_correction = false;
  /// lx at the eye; 0: that of the picture. A picture of less than the hemisphere before the eye needs it.
  double vertical_illuminance = 0;
};

struct GlareFigures {
  double vertical_illuminance = 0;  // lx, of a plane across the line of sight, at the eye
  double background_luminance = 0;  // cd/m^2: the illuminance without the sources, over pi
  double mean_luminance = 0;        // cd/m^2, of the whole picture
  double daylight_glare_probability = 0;
  double unified_glare_rating = 0;  // -infinity without a source
  double daylight_glare_index = 0;  // -infinity without a source
  FoundSources found;
};

/// Unified Glare Rating [CIE117]: 8 lg (0.25 / background sum L^2 solid angle / position index^2).
double unified_glare_rating(std::span<const GlareSource> sources, double background_luminance);

/// Daylight Glare Probability [Wienold2006]: 5.87e-5 E + 9.18e-2 lg (1 + sum L^2 solid angle / (E^1.87
/// position index^2)) + 0.16, for 0.2 to 0.8 and E above 380 lx; here 1 at most.
double daylight_glare_probability(std::span<const GlareSource> sources, double vertical_illuminance,
                                  bool low_light_correction = false);

/// Daylight Glare Index [Hopkinson1972, Chauvel1982]: 10 lg sum 0.478 L^1.6 S^0.8 / (background + 0.07
/// sqrt(solid angle) L), where S is the solid angle over the position index squared.
double daylight_glare_index(std::span<const GlareSource> sources, double background_luminance);

/// Searches a picture for sources and rates it. InvalidArgument as of check_picture(), and for options that
/// are negative.
absl::StatusOr<GlareFigures> glare_of(const LuminancePicture& picture, const GlareOptions& options = {});

}  // namespace tessera::photometry
