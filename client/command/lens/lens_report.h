// The report of `tessera lens`.
#pragma once

#include <string>
#include <vector>

#include "optics/ghosts.h"
#include "optics/image_quality.h"
#include "optics/lens_system.h"
#include "plot/lens_drawing.h"

namespace tessera::client {

struct LensReport {
  std::string name, source;
  double focal_length = 0, f_number = 0, t_number = 0;     // lengths in millimetres
  double focus = 0, film_distance = 0, magnification = 0;  // distance of the film from the last vertex
  double entrance_pupil = 0, entrance_diameter = 0;        // place behind the first vertex
  double exit_pupil = 0, exit_diameter = 0;                // place behind the last vertex
  double front_principal = 0, back_principal = 0, length = 0;
  double film_diagonal = 0, field_degrees = 0;  // seen across the diagonal; 0: not all of it is lit
  double circle_of_confusion = 0, near = 0, far = 0;
  std::vector<double> frequencies;
  std::vector<optics::FieldPoint> field;
  std::vector<double> dark_heights;  // places of the film without light
  std::vector<optics::Ghost> ghosts;
};

LensReport report_of(const optics::LensSystem& lens, double film_diagonal);

std::string text_of(const LensReport& report, std::size_t width);
std::string json_of(const LensReport& report);

/// A section of the lens with rays to the middle of the film, and to places towards its edge.
LensDrawing drawing_of(const optics::LensSystem& lens, double film_diagonal);

}  // namespace tessera::client
