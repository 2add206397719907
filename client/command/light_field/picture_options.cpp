#include "command/light_field/picture_options.h"

#include <algorithm>
#include <iostream>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "command/exit_code.h"

namespace tessera::client {

using light_field::Interpolation;

void define_set_and_output(Command& command, PictureOptions& options, const char* output) {
  options.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  command.add("SET", options.set, "the folder of the light field").required();
  command.add("-o,--output", options.output, output).type_name("FILE").required();
}

void define_picture_computation(Command& command, PictureOptions& options) {
  command.group("Computation");
  command.add("--threads", options.threads, "rows looked up at once")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.add_flag("--quiet", options.quiet, "say nothing of missing rays");
}

void define_interpolation(Command& command, std::optional<Interpolation>& by) {
  const auto read = [&by](const std::string& word) {
    by = word == "depth"       ? Interpolation::kDepth
         : word == "lumigraph" ? Interpolation::kLumigraph
                               : Interpolation::kQuadrilinear;
    return absl::OkStatus();
  };
  command
      .add_read_by(
          "--by", read,
          "interpolation: quadrilinear, depth or lumigraph (default: depth of grids, else lumigraph)")
      .type_name("NAME")
      .one_of({"quadrilinear", "depth", "lumigraph"});
}

Interpolation interpolation_of(const light_field::Manifest& manifest, std::optional<Interpolation> by) {
  return by.value_or(manifest.arrangement.grids.empty() ? Interpolation::kLumigraph : Interpolation::kDepth);
}

std::unique_ptr<light_field::LightField> open_set(const std::string& folder, int& exit_code) {
  auto field = light_field::LightField::open(folder);
  if (field.ok()) return *std::move(field);
  exit_code = report(kUsage, std::string(field.status().message()));
  return nullptr;
}

int report_damage(const light_field::LightField& field) {
  const std::vector<light_field::Damage> damage = field.damage();
  if (damage.empty()) return kDone;
  for (const light_field::Damage& each : damage) std::cerr << each.text() << '\n';
  return report(kIncomplete, absl::StrCat(field.folder(), " is damaged; tessera lightfield repair ",
                                          field.folder(), " renders what is lost again"));
}

int report_rays(const light_field::LightField& field, const light_field::Picture& picture, bool quiet) {
  if (picture.missing > 0 && !quiet) {
    std::cerr << "warning: " << picture.missing << " of " << picture.rays
              << " rays are not in the light field: their pixels have alpha and 'known' 0\n";
  }
  return report_damage(field);
}

}  // namespace tessera::client
