#include "command/report/false_color_options.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "command/report/output.h"
#include "image/color_space.h"
#include "plot/picture_map.h"

namespace tessera::client {
namespace {

absl::StatusOr<ValueRange> read_range(const std::string& text) {
  const std::vector<std::string> parts = absl::StrSplit(text, ',');
  ValueRange range;
  const bool read =
      parts.size() == 2 && absl::SimpleAtod(parts[0], &range.low) && absl::SimpleAtod(parts[1], &range.high);
  if (!read || !std::isfinite(range.low) || !std::isfinite(range.high) || !(range.low < range.high)) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", text, "' is not two numbers LOW,HIGH of which the second is larger"));
  }
  return range;
}

absl::Status write_luminance(const ValueGrid& grid, const Image& image, const std::string& path) {
  Image luminance;
  luminance.data = image.data, luminance.display = image.display;
  luminance.metadata = image.metadata;
  luminance.metadata.erase(kChromaticities);
  luminance.metadata["whiteLuminance"] = 1.f;
  std::ranges::transform(grid.values, luminance.add("Y").values.begin(),
                         [](double value) { return static_cast<float>(value); });
  return write_exr(luminance, path);
}

}  // namespace

void define_false_color_options(Command& command, FalseColorChoice& choice) {
  const options::Option asked = command.add_flag(
      "--false-color", choice.asked,
      "of an .exr: its luminance in cd/m^2 as colours with a legend; into an .exr as numbers");
  command.add("--color-map", choice.map, "colours of --false-color")
      .one_of(color_map_names())
      .needs(asked)
      .with_default();
  command.add("--scale", choice.scale, "of --false-color")
      .one_of({"linear", "log"})
      .needs(asked)
      .with_default();
  command
      .add_read_by(
          "--range",
          [&choice](const std::string& text) {
            const absl::StatusOr<ValueRange> range = read_range(text);
            if (!range.ok()) return range.status();
            choice.range = *range;
            return absl::OkStatus();
          },
          "ends of the scale, cd/m^2 (default: those of the picture)")
      .type_name("LOW,HIGH")
      .needs(asked);
  command.add_flag("--isolines", choice.isolines, "lines of equal luminance, with their values").needs(asked);
  constexpr double kMostLuminance = 1e12;
  command
      .add("--cd-per-m2", choice.white_luminance,
           "luminance of pixels of 1 (default: the file's whiteLuminance, or 683)")
      .type_name("NUMBER")
      .in_range(1e-12, kMostLuminance)
      .needs(asked);
}

absl::Status write_false_color_picture(const Image& image, const FalseColorChoice& choice,
                                       const std::string& path) {
  const absl::StatusOr<ValueGrid> grid =
      luminance_grid(image, white_luminance(image, choice.white_luminance));
  if (!grid.ok()) return grid.status();
  if (is_exr(path)) return write_luminance(*grid, image, path);
  const absl::StatusOr<ColorMap> map = color_map_of(choice.map);
  if (!map.ok()) return map.status();
  FalseColorOptions look = picture_look();
  look.map = *map;
  look.scale = choice.scale == "log" ? ScaleKind::kLogarithmic : ScaleKind::kLinear;
  look.range = choice.range;
  look.isolines = choice.isolines;
  if (look.range && look.scale == ScaleKind::kLogarithmic && !(look.range->low > 0))
    return absl::InvalidArgumentError("a logarithmic scale begins above 0: --range LOW,HIGH");
  return write_false_color(*grid, look, path);
}

}  // namespace tessera::client
