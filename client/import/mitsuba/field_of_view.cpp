#include "import/mitsuba/field_of_view.h"

#include <cmath>
#include <numbers>

#include "import/input/concat.h"
#include "import/mitsuba/document/value_text.h"

namespace tessera::client::mitsuba {
namespace {

// Half the diagonal of a frame of 35 mm film, millimetres.
const double kHalfFilmDiagonal = std::hypot(36.0, 24.0) / 2;

double half_width_of_half_diagonal(double half_diagonal, double aspect) {
  return half_diagonal / std::sqrt(1 + 1 / (aspect * aspect));
}

}  // namespace

double read_half_width(PropertyReader& reader, double aspect) {
  if (!reader.has("fov")) {
    std::string length = reader.text("focal_length", "50mm");
    if (length.ends_with("mm")) length.resize(length.size() - 2);
    const std::optional<double> millimetres = parse_float(length);
    if (millimetres && *millimetres > 0)
      return half_width_of_half_diagonal(kHalfFilmDiagonal / *millimetres, aspect);
    reader.error(*reader.find("focal_length"),
                 concat("expected a length like \"50mm\", found \"", length, "\""));
    return 1;
  }
  if (reader.has("focal_length")) {
    reader.error(concat(reader.object().title(), ": \"fov\" and \"focal_length\" exclude each other"));
    reader.ignore({"focal_length"});
  }
  const double fov = reader.number("fov", 90);
  if (!(fov > 0 && fov < 180)) {
    reader.error(*reader.find("fov"), concat("a field of view of ", fov, " degrees is not in (0, 180)"));
    return 1;
  }
  const double tangent = std::tan(fov * std::numbers::pi / 360);
  const std::string axis = reader.keyword("fov_axis", "x");
  if (axis == "x" || (axis == "smaller" && aspect <= 1) || (axis == "larger" && aspect > 1)) return tangent;
  if (axis == "y" || axis == "smaller" || axis == "larger") return tangent * aspect;
  if (axis == "diagonal") return half_width_of_half_diagonal(tangent, aspect);
  reader.error(*reader.find("fov_axis"),
               concat("expected x, y, diagonal, smaller or larger, found \"", axis, "\""));
  return tangent;
}

}  // namespace tessera::client::mitsuba
