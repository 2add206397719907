// tessera lightfield info, check, repair and export: sets as files.
#include <algorithm>
#include <iostream>
#include <memory>
#include <set>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "capture/pictures.h"
#include "capture/set_writer.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/light_field/commands.h"
#include "command/light_field/picture_options.h"
#include "command/light_field/provenance.h"
#include "command/light_field/read_numbers.h"
#include "command/light_field/view_jobs.h"
#include "command/read_option.h"
#include "command/render_options.h"
#include "command/report/output.h"
#include "image/exr/rows.h"
#include "wire/scene_views.h"

namespace tessera::client {
namespace {

using light_field::Damage;
using light_field::Manifest;

std::string facts_of(const Manifest& manifest) {
  const light_field::Arrangement& arrangement = manifest.arrangement;
  std::uint64_t bytes = 0;
  for (const light_field::View& view : manifest.views) bytes += view.file_bytes;
  std::string text = absl::StrFormat("%d views of %dx%d pixels, %.4g MB: %s colours in tiles of %d, %s",
                                     manifest.views.size(), manifest.width, manifest.height,
                                     1e-6 * static_cast<double>(bytes), manifest.half ? "16-bit" : "32-bit",
                                     manifest.tile_size, light_field::word_of(manifest.compression));
  if (manifest.psnr_db > 0)
    absl::StrAppendFormat(&text, " (level %.4g, PSNR %.4g dB)", manifest.dwa_level, manifest.psnr_db);
  absl::StrAppend(&text, "\n", manifest.colour_space, "\n");
  const Imath::V3d& target = arrangement.target;
  absl::StrAppendFormat(&text, "%s, about %.6g,%.6g,%.6g", arrangement.kind, target.x, target.y, target.z);
  if (arrangement.radius > 0) absl::StrAppendFormat(&text, ", radius %.6g", arrangement.radius);
  text += "\n";
  for (const light_field::CameraGrid& grid : arrangement.grids) {
    absl::StrAppendFormat(&text, "grid %s: %dx%d cameras, %.6g x %.6g apart, second plane at %.6g\n",
                          grid.name, grid.columns, grid.rows, grid.spacing_x, grid.spacing_y, grid.focus);
  }
  const light_field::Provenance& made = manifest.provenance;
  absl::StrAppend(&text, made.scene, ", ", made.integrator, ", ", made.samples_per_pixel,
                  " samples a pixel, seed ", made.seed, ", by ", made.program, "\n");
  return text;
}

int show_set(const std::string& set) {
  const auto manifest = light_field::read_manifest(set);
  if (!manifest.ok()) return report(kUsage, std::string(manifest.status().message()));
  std::cout << facts_of(*manifest);
  return kDone;
}

std::vector<Damage> damage_of(const Manifest& manifest, const std::string& set) {
  std::vector<Damage> all;
  for (std::uint32_t view = 0; view < manifest.views.size(); ++view) {
    const std::vector<Damage> found = light_field::check_view(manifest, set, view);
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

int check_set(const std::string& set) {
  const auto manifest = light_field::read_manifest(set);
  if (!manifest.ok()) return report(kUsage, std::string(manifest.status().message()));
  const std::vector<Damage> damage = damage_of(*manifest, set);
  for (const Damage& each : damage) std::cout << each.text() << '\n';
  if (damage.empty()) {
    std::cout << manifest->views.size() << " views are as they were written\n";
    return kDone;
  }
  return report(kIncomplete,
                absl::StrCat(set, " is damaged; tessera lightfield repair ", set, " renders it again"));
}

struct RepairOptions {
  std::string set;
  RenderOptions scene;
};

/// Renders one view as it was rendered, and puts it where it was.
absl::Status repair_view(std::uint32_t number, ImportedScene& imported, ViewJobOptions how,
                         SetWriter& writer) {
  const v1::Scene all = imported.scene;
  if (absl::Status s = wire::keep_view(number, imported.scene); !s.ok()) return s;
  how.job.view = number;
  const auto job = prepare_views(imported, how);
  absl::StatusOr<std::vector<Image>> images =
      job.ok() ? render_views(**job, how) : absl::StatusOr<std::vector<Image>>(job.status());
  imported.scene = all;
  if (!images.ok()) return images.status();
  return writer.write(number, images->front());
}

int repair_set(RepairOptions options, Interrupt& interrupt) {
  auto manifest = light_field::read_manifest(options.set);
  if (!manifest.ok()) return report(kUsage, std::string(manifest.status().message()));
  std::set<std::uint32_t> views;
  for (const Damage& damage : damage_of(*manifest, options.set)) {
    std::cerr << damage.text() << '\n';
    views.insert(damage.view);
  }
  if (views.empty()) {
    std::cerr << manifest->views.size() << " views are as they were written\n";
    return kDone;
  }
  if (absl::Status s = take_provenance(manifest->provenance, options.scene); !s.ok())
    return report(kUsage, absl::StrCat(options.set, ": ", std::string(s.message())));
  options.scene.job.resolution = Resolution{manifest->width, manifest->height};
  int exit_code = kDone;
  const std::unique_ptr<LoadedJob> loaded = load_job(options.scene, exit_code);
  if (loaded == nullptr) return exit_code;
  drop_picture_settings(loaded->imported);
  std::vector<light_field::Pinhole> cameras;
  for (const light_field::View& view : manifest->views) cameras.push_back(view.camera);
  set_cameras(cameras, {manifest->width, manifest->height}, loaded->imported.scene);
  ViewJobOptions how;
  how.job = options.scene.job;
  how.name = absl::StrCat("repair of ", options.set);
  how.threads = options.scene.threads, how.quiet = options.scene.quiet;
  how.stop = interrupt.token();
  const auto whole = prepare_views(loaded->imported, how);
  if (!whole.ok()) return report_view_error(whole.status());
  if ((*whole)->spec.content().scene() != manifest->provenance.scene_digest) {
    return report(kUsage, absl::StrCat(options.scene.scene, " is not the scene of the set as it was: ",
                                       options.set, " has to be captured again"));
  }
  std::size_t others = 0;
  for (const std::uint32_t view : views) {
    const std::string before = manifest->views[view].file;
    SetWriter writer(options.set, *manifest);
    if (absl::Status s = repair_view(view, loaded->imported, how, writer); !s.ok())
      return report_view_error(s);
    others += manifest->views[view].file != before ? 1 : 0;
    if (absl::Status s = writer.finish(); !s.ok()) return report(kIncomplete, std::string(s.message()));
  }
  std::cerr << views.size() << " views were rendered again";
  if (others > 0) std::cerr << ", " << others << " of them with other bits than before, on another machine";
  std::cerr << '\n';
  return kDone;
}

struct ExportOptions {
  PictureOptions picture;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> quilt;
  bool multiview = false;
  std::optional<light_field::Interpolation> by;
};

int export_views(const ExportOptions& options, light_field::LightField& field) {
  std::vector<Image> images;
  for (std::uint32_t view = 0; view < field.view_count(); ++view) {
    auto image = image_of_view(field, view);
    if (!image.ok()) return report(kIncomplete, std::string(image.status().message()));
    images.push_back(*std::move(image));
  }
  std::vector<ExrView> views;
  for (const Image& image : images) views.push_back({&image, nullptr});
  const absl::Status written =
      write_exr_views(views, options.picture.output, {.half = field.manifest().half});
  return written.ok() ? kDone : report(kIncomplete, std::string(written.message()));
}

int export_set(const ExportOptions& options) {
  if (options.quilt.has_value() == options.multiview)
    return report(kUsage, "give --quilt or --multiview: what is written");
  absl::Status output = check_output(options.picture.output);
  if (output.ok() && options.multiview && !is_exr(options.picture.output))
    output = absl::InvalidArgumentError("--multiview writes an .exr");
  if (!output.ok()) return report(kUsage, std::string(output.message()));
  int exit_code = kDone;
  const auto field = open_set(options.picture.set, exit_code);
  if (field == nullptr) return exit_code;
  if (options.multiview) return export_views(options, *field);
  const auto quilt = quilt_of(*field, {options.quilt->first, options.quilt->second},
                              interpolation_of(field->manifest(), options.by), options.picture.threads);
  if (!quilt.ok()) return report(kUsage, std::string(quilt.status().message()));
  if (absl::Status s = write_image(image_of(*quilt), options.picture.output); !s.ok())
    return report(kIncomplete, std::string(s.message()));
  return report_rays(*field, *quilt, options.picture.quiet);
}

void add_set_command(CommandLine& line, const char* name, const char* description,
                     int (*action)(const std::string&), const char* example) {
  auto set = std::make_shared<std::string>();
  Command command = line.add_command(name, description);
  command.add("SET", *set, "the folder of the light field").required();
  command.example(example);
  command.does([set, action](Interrupt&) { return action(*set); });
}

void add_light_field_repair(CommandLine& line) {
  auto options = std::make_shared<RepairOptions>();
  options->scene.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  Command command =
      line.add_command("lightfield repair", "Render again the views of a light field that are damaged");
  command.add("SET", options->set, "the folder of the light field").required();
  command.add("SCENE", options->scene.scene,
              "the scene, where it is no more at the place that the set names");
  command.group("Computation");
  command.add("--threads", options->scene.threads, "tiles rendered at once")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.add_flag("--quiet", options->scene.quiet, "no progress, no warnings");
  command.example("tessera lightfield repair box.lf");
  command.does([options](Interrupt& interrupt) { return repair_set(*options, interrupt); });
}

void add_light_field_export(CommandLine& line) {
  auto options = std::make_shared<ExportOptions>();
  Command command =
      line.add_command("lightfield export", "Write the views of a light field into one picture");
  define_set_and_output(command, options->picture, "the picture: .exr or .png");
  command.group("Pictures");
  add_parsed(command, "--quilt", options->quilt, parse_counts,
             "views from left to right, the first one at the lower left, for light-field displays")
      .type_name("CxR");
  command.add_flag("--multiview", options->multiview, "all views as parts of an .exr, with their depth");
  define_interpolation(command, options->by);
  define_picture_computation(command, options->picture);
  command.example("tessera lightfield export box.lf --quilt 8x6 -o box_qs8x6a1.png");
  command.does([options](Interrupt&) { return export_set(*options); });
}

}  // namespace

void add_light_field_command(CommandLine& line) {
  Command command = line.add_command("lightfield", "Light fields: rays of a scene, kept to be looked up");
  command.example("tessera lightfield capture box.pbrt -o box.lf --grid 9x9 --spp 64");
  command.example("tessera lightfield view box.lf --at 0.1,1,6 --toward 0,1,0 -o new.exr");
  add_light_field_capture(line);
  add_light_field_view(line);
  add_light_field_refocus(line);
  add_set_command(line, "lightfield info", "Tell what a light field holds", &show_set,
                  "tessera lightfield info box.lf");
  add_set_command(line, "lightfield check", "Hold the files of a light field against its manifest",
                  &check_set, "tessera lightfield check box.lf");
  add_light_field_repair(line);
  add_light_field_export(line);
}

}  // namespace tessera::client
