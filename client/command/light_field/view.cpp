// tessera lightfield view SET -o PICTURE: looks a new picture up.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>

#include "absl/strings/str_format.h"
#include "capture/camera_rays.h"
#include "capture/pictures.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/jobs/job_settings.h"
#include "command/light_field/commands.h"
#include "command/light_field/picture_options.h"
#include "command/light_field/read_numbers.h"
#include "command/read_option.h"
#include "command/report/output.h"

namespace tessera::client {
namespace {

struct ViewOptionsOfSet {
  PictureOptions picture;
  std::string camera;
  std::optional<std::array<double, 3>> at, toward, up;
  std::optional<double> fov;
  std::optional<Resolution> resolution;
  std::optional<light_field::Interpolation> by;
  std::optional<double> focus;
};

Imath::V3d to_vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// Across the shorter side of the set's first view, degrees.
double field_of_view(const light_field::Manifest& manifest) {
  const double side = std::min(manifest.width, manifest.height);
  return 2 * std::atan(side / (2 * manifest.views.front().camera.fx)) * 180 / std::numbers::pi;
}

/// The camera at --at, or the one of a file.
absl::StatusOr<v1::Camera> new_camera(const ViewOptionsOfSet& options,
                                      const light_field::Manifest& manifest) {
  if (!options.camera.empty()) return read_camera(options.camera);
  const light_field::Matrix4& first = manifest.views.front().camera.world_from_camera;
  const Imath::V3d place = to_vector(*options.at);
  const Imath::V3d toward = options.toward ? to_vector(*options.toward) : manifest.arrangement.target;
  if ((toward - place).length2() == 0)
    return absl::InvalidArgumentError("--toward is where the camera is: it has no direction");
  const Imath::V3d up =
      options.up ? to_vector(*options.up) : light_field::transformed_vector(first, {0, 1, 0});
  v1::Camera camera;
  camera.mutable_perspective()->set_fov_degrees(
      static_cast<float>(options.fov.value_or(field_of_view(manifest))));
  for (const double element : light_field::looking(place, toward - place, up, light_field::mirrors(first)))
    camera.mutable_world_from_camera()->add_elements(element);
  return camera;
}

int view_set(const ViewOptionsOfSet& options) {
  if (options.camera.empty() == !options.at)
    return report(kUsage, "give --camera, or --at: where the picture is seen from");
  if (absl::Status s = check_output(options.picture.output); !s.ok())
    return report(kUsage, std::string(s.message()));
  int exit_code = kDone;
  const auto field = open_set(options.picture.set, exit_code);
  if (field == nullptr) return exit_code;
  const light_field::Manifest& manifest = field->manifest();
  const Resolution film = options.resolution.value_or(Resolution{manifest.width, manifest.height});
  const auto camera = new_camera(options, manifest);
  if (!camera.ok()) return report(kUsage, std::string(camera.status().message()));
  auto rays = camera_rays(*camera, {film.width, film.height});
  if (!rays.ok()) return report(kUsage, std::string(rays.status().message()));
  light_field::PictureRequest request;
  request.width = film.width, request.height = film.height;
  request.rays = *std::move(rays);
  request.by = interpolation_of(manifest, options.by);
  request.focus = options.focus;
  request.threads = options.picture.threads;
  const auto start = std::chrono::steady_clock::now();
  const auto picture = interpolate(*field, request);
  if (!picture.ok()) return report(kUsage, std::string(picture.status().message()));
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
  if (!options.picture.quiet)
    std::cerr << absl::StreamFormat("looked up %d rays in %.3g ms\n", picture->rays, spent.count());
  if (absl::Status s = write_image(image_of(*picture), options.picture.output); !s.ok())
    return report(kIncomplete, std::string(s.message()));
  return report_rays(*field, *picture, options.picture.quiet);
}

}  // namespace

void add_light_field_view(CommandLine& line) {
  auto options = std::make_shared<ViewOptionsOfSet>();
  Command command = line.add_command("lightfield view", "Look a picture of a new camera up in a light field");
  define_set_and_output(command, options->picture, "the picture: .exr or .png");
  command.group("Camera");
  const Option camera =
      command.add("--camera", options->camera, "a camera of a scene, as text (docs/light-field.md)")
          .type_name("FILE.textproto");
  const Option at =
      add_parsed(command, "--at", options->at, parse_triple, "where a perspective camera stands")
          .type_name("X,Y,Z")
          .excludes(camera);
  add_parsed(command, "--toward", options->toward, parse_triple,
             "a point that it looks at (default: the middle of the set)")
      .type_name("X,Y,Z")
      .needs(at);
  add_parsed(command, "--up", options->up, parse_triple, "direction that is up in the picture")
      .type_name("X,Y,Z")
      .needs(at);
  command.add("--fov", options->fov, "across the shorter side, degrees (default: the views')")
      .in_range(0.01, 175)
      .type_name("DEGREES");
  add_parsed(command, "--resolution", options->resolution, parse_resolution,
             "of the picture (default: that of the views)")
      .type_name("WxH");
  command.group("Interpolation");
  define_interpolation(command, options->by);
  command
      .add("--focus", options->focus, "from grids to the second plane of quadrilinear (default: the set's)")
      .in_range(1e-30, 1e30)
      .type_name("LENGTH");
  define_picture_computation(command, options->picture);
  command.example("tessera lightfield view box.lf --at 0.1,1,6 --toward 0,1,0 -o new.exr");
  command.example("tessera lightfield view box.lf --camera wide.textproto --by depth -o new.exr");
  command.does([options](Interrupt&) { return view_set(*options); });
}

}  // namespace tessera::client
