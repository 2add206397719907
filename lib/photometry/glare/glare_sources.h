// Sources of glare in a picture of luminances.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "photometry/glare/position_index.h"

namespace tessera::photometry {

/// Pixels of a fisheye, rows from the top. Pixels that the view does not hold have a solid angle of 0.
struct LuminancePicture {
  int width = 0, height = 0;
  std::span<const float> luminances;  // cd/m^2
  std::span<const ViewDirection> directions;
  std::span<const double> solid_angles;  // sr

  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// InvalidArgument where the arrays do not have the picture's size, or a number is negative or not finite.
absl::Status check_picture(const LuminancePicture& picture);

/// A circular part of the view that somebody works at.
struct TaskZone {
  ViewDirection middle = {};
  double radius_degrees = 0;  // 0: there is none, and the mean is that of the view
};

struct SourceSearch {
  /// Pixels that are brighter are a source: this luminance in cd/m^2; 0: `factor` times the mean luminance of
  /// the task zone or of the view. (evalglare: 2000 cd/m^2, or a factor of 5.)
  double threshold = 2000;
  double factor = 5;
  TaskZone task = {};
  /// Sources whose middles are nearer than this become one, radians.
  double search_radius = 0.2;
};

struct GlareSource {
  ViewDirection middle = {};  // by luminance times solid angle
  double luminance = 0;       // mean, cd/m^2
  double solid_angle = 0;     // sr
  double position_index = 1;
  double illuminance = 0;  // lx, at the eye, of a plane across the line of sight
  std::size_t pixels = 0;
};

struct FoundSources {
  double threshold = 0;  // cd/m^2, that was used
  bool merged =
      true;  // false: groups of pixels are too many to be merged, more than 4096; the picture is noisy
  std::vector<GlareSource>
      sources;  // brightest first, by luminance^2 times solid angle over position index^2
  /// For each pixel the number of its source from 1 on, in the order of `sources`; 0: none.
  std::vector<std::int32_t> source_of_pixel;
};

/// Pixels above the threshold that touch, corners included, are a source; then the two sources whose middles
/// are nearest become one, until none are nearer than the search radius.
FoundSources find_glare_sources(const LuminancePicture& picture, const SourceSearch& search);

/// Mean luminance by solid angle, of the task zone or, without one, of the view; 0 where nothing is in it.
double mean_luminance(const LuminancePicture& picture, const TaskZone& task = {});

}  // namespace tessera::photometry
