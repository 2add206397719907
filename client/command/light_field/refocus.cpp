// tessera lightfield refocus SET -o PICTURE: pictures through lenses as wide as the set's cameras.
#include "light_field/refocus.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "capture/pictures.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/frames/frame_list.h"
#include "command/interrupt.h"
#include "command/light_field/commands.h"
#include "command/light_field/picture_options.h"
#include "command/light_field/read_numbers.h"
#include "command/read_option.h"
#include "command/report/output.h"
#include "light_field/focal_stack.h"

namespace tessera::client {
namespace {

struct RefocusOptions {
  PictureOptions picture;
  std::optional<double> focus, aperture;
  std::optional<std::array<double, 2>> at, slope, range;
  std::uint32_t blades = 0, planes = 32;
  double blade_degrees = 0;
  bool all_in_focus = false, depth_from_focus = false;
  std::uint32_t sweep = 0;
};

light_field::Aperture aperture_of(const RefocusOptions& options, const light_field::CameraGrid& grid) {
  light_field::Aperture aperture;
  if (options.at) aperture.x = (*options.at)[0], aperture.y = (*options.at)[1];
  aperture.radius = options.aperture.value_or(light_field::largest_radius(grid));
  aperture.blades = options.blades, aperture.blade_degrees = options.blade_degrees;
  return aperture;
}

/// Near and far: as given, or half and twice the distance of the set's second plane.
std::pair<double, double> range_of(const RefocusOptions& options, const light_field::CameraGrid& grid) {
  if (options.range) return {(*options.range)[0], (*options.range)[1]};
  return {0.5 * grid.focus, 2 * grid.focus};
}

int write_stack(const RefocusOptions& options, light_field::LightField& field,
                const light_field::CameraGrid& grid) {
  light_field::FocalStackOptions how;
  std::tie(how.near, how.far) = range_of(options, grid);
  how.planes = options.planes, how.threads = options.picture.threads;
  const auto stack = focal_stack(field, aperture_of(options, grid), how);
  if (!stack.ok()) return report(kUsage, std::string(stack.status().message()));
  Image image = image_of(stack->sharp);
  if (options.depth_from_focus) image.add("depth.Z").values = stack->depths;
  if (absl::Status s = write_image(image, options.picture.output); !s.ok())
    return report(kIncomplete, std::string(s.message()));
  return report_rays(field, stack->sharp, options.picture.quiet);
}

int write_refocused(const RefocusOptions& options, light_field::LightField& field,
                    const light_field::CameraGrid& grid, double distance, const std::string& path) {
  light_field::FocusPlane plane{.distance = distance};
  if (options.slope) plane.slope_x = (*options.slope)[0], plane.slope_y = (*options.slope)[1];
  const auto picture = refocus(field, aperture_of(options, grid), plane, options.picture.threads);
  if (!picture.ok()) return report(kUsage, std::string(picture.status().message()));
  if (absl::Status s = write_image(image_of(*picture), path); !s.ok())
    return report(kIncomplete, std::string(s.message()));
  return report_rays(field, *picture, options.picture.quiet);
}

/// Pictures from near to far, at distances whose inverses are equally far apart.
int write_sweep(const RefocusOptions& options, light_field::LightField& field,
                const light_field::CameraGrid& grid, Interrupt& interrupt) {
  if (!has_frame_mark(options.picture.output))
    return report(kUsage, "--sweep writes many pictures: the name needs a place for their numbers, ####");
  const auto [near, far] = range_of(options, grid);
  if (!(near > 0) || !(far > near)) return report(kUsage, "--range: two distances above 0, the nearer first");
  const std::stop_token stop = interrupt.token();
  int exit_code = kDone;
  for (std::uint32_t i = 0; i < options.sweep; ++i) {
    if (stop.stop_requested()) return kInterrupted;
    const double part = options.sweep > 1 ? static_cast<double>(i) / (options.sweep - 1) : 0;
    const double distance = 1 / std::lerp(1 / near, 1 / far, part);
    const int code =
        write_refocused(options, field, grid, distance, path_of_frame(options.picture.output, i + 1));
    if (code == kUsage) return code;
    exit_code = std::max(exit_code, code);
  }
  return exit_code;
}

int refocus_set(const RefocusOptions& options, Interrupt& interrupt) {
  const bool stack = options.all_in_focus || options.depth_from_focus;
  if (options.focus.has_value() + stack + (options.sweep > 0) != 1)
    return report(kUsage, "give --focus, --sweep, or --all-in-focus and --depth-from-focus: what is sharp");
  if (absl::Status s = check_output(options.picture.output); !s.ok())
    return report(kUsage, std::string(s.message()));
  int exit_code = kDone;
  const auto field = open_set(options.picture.set, exit_code);
  if (field == nullptr) return exit_code;
  const auto grid = light_field::only_grid(field->manifest());
  if (!grid.ok())
    return report(kUsage, absl::StrCat(options.picture.set, ": ", std::string(grid.status().message())));
  if (stack) return write_stack(options, *field, *grid);
  if (options.sweep > 0) return write_sweep(options, *field, *grid, interrupt);
  return write_refocused(options, *field, *grid, *options.focus, options.picture.output);
}

}  // namespace

void add_light_field_refocus(CommandLine& line) {
  auto options = std::make_shared<RefocusOptions>();
  Command command =
      line.add_command("lightfield refocus", "Focus on any plane of a light field, through any aperture");
  define_set_and_output(command, options->picture, "the picture: .exr or .png");
  command.group("Focus");
  command.add("--focus", options->focus, "from the cameras' plane to what is sharp")
      .in_range(1e-30, 1e30)
      .type_name("LENGTH");
  add_parsed(command, "--slope", options->slope, parse_pair,
             "by how much more for each unit to the right, and up: a tilted plane")
      .type_name("X,Y");
  command.add("--sweep", options->sweep, "so many pictures from the near end of --range to the far one")
      .in_range(1, 1 << 20);
  command.add_flag("--all-in-focus", options->all_in_focus, "each pixel where the views agree best on it");
  command.add_flag("--depth-from-focus", options->depth_from_focus,
                   "the same, with the distance of that plane as channel depth.Z");
  add_parsed(command, "--range", options->range, parse_pair,
             "distances that are looked at (default: half and twice that of the set's second plane)")
      .type_name("NEAR,FAR");
  command.add("--planes", options->planes, "so many between them").in_range(2, 4096).with_default();
  command.group("Aperture");
  command.add("--aperture", options->aperture, "radius; 0 is a pinhole (default: all within the grid)")
      .in_range(0, 1e30)
      .type_name("LENGTH");
  command.add("--blades", options->blades, "corners of the aperture, 3 to 64; else it is round")
      .in_range(3, 64)
      .type_name("N");
  command.add("--blade-angle", options->blade_degrees, "direction of its first corner, degrees")
      .type_name("DEGREES");
  add_parsed(command, "--at", options->at, parse_pair, "the aperture's middle, from that of the grid")
      .type_name("X,Y");
  define_picture_computation(command, options->picture);
  command.example("tessera lightfield refocus box.lf --focus 6.2 --aperture 0.3 -o sharp.exr");
  command.example("tessera lightfield refocus box.lf --sweep 24 --range 4,9 -o sweep.####.png");
  command.does([options](Interrupt& interrupt) { return refocus_set(*options, interrupt); });
}

}  // namespace tessera::client
