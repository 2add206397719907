// tessera lightfield capture SCENE -o SET: renders the views of a light field, all in one job.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "base/available_memory.h"
#include "capture/plan.h"
#include "capture/set_writer.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/light_field/commands.h"
#include "command/light_field/provenance.h"
#include "command/light_field/read_numbers.h"
#include "command/light_field/view_jobs.h"
#include "command/read_option.h"
#include "command/render_options.h"
#include "command/server_option.h"
#include "command/setting_options.h"
#include "local/checkpoint.h"

namespace tessera::client {
namespace {

namespace fs = std::filesystem;

/// The width of grids where none is given, as a part of the distance to the focal plane.
constexpr double kUsualBaseline = 0.2;

struct CaptureOptions {
  RenderOptions scene;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> grid;
  std::optional<double> spacing, baseline, focus, radius, fov;
  std::optional<std::uint32_t> sphere;
  std::optional<std::array<double, 3>> target;
  std::string box;  // "scene", or six numbers; empty: none
  bool outwards = false;
  Resolution size{512, 512};
  light_field::Compression compression = light_field::Compression::kZip;
  double dwa_level = 45;
  bool full_floats = false;
  std::uint32_t tile_size = 64;
  bool on_farm = false;
  ServerOption server;
};

/// Tells the bounds of the scene, which are found when they are first needed.
class LazyBounds {
 public:
  LazyBounds(const PreparedJob& job, int threads) : job_(job), threads_(threads) {}

  absl::StatusOr<SceneBounds> get() {
    if (!bounds_) bounds_ = bounds_of_scene(job_, threads_);
    return *bounds_;
  }

 private:
  const PreparedJob& job_;
  const int threads_;
  std::optional<absl::StatusOr<SceneBounds>> bounds_;
};

absl::StatusOr<CapturePlan> plan_grid(const CaptureOptions& options, const v1::Camera& camera,
                                      const ViewSize& size, LazyBounds& bounds) {
  TwoPlaneRequest request;
  if (options.grid) std::tie(request.columns, request.rows) = *options.grid;
  if (options.focus) {
    request.focus = *options.focus;
  } else {
    // The middle of the scene, along the camera's axis.
    const auto around = bounds.get();
    if (!around.ok()) return around.status();
    light_field::Pinhole eye;
    if (camera.world_from_camera().elements_size() == 16)
      std::ranges::copy(camera.world_from_camera().elements(), eye.world_from_camera.begin());
    request.focus = (around->all.center() - eye.place()).dot(eye.direction(0, 0).normalized());
    if (around->all.isEmpty() || !(request.focus > 0))
      return absl::InvalidArgumentError("the scene's middle is not before its camera: --focus says what is");
  }
  const std::uint32_t gaps = std::max({request.columns, request.rows, 2u}) - 1;
  const double baseline = options.baseline.value_or(kUsualBaseline * request.focus);
  request.spacing_x = request.spacing_y = options.spacing.value_or(baseline / gaps);
  return plan_two_plane(request, camera, options.fov, size);
}

absl::StatusOr<CapturePlan> make_plan(const CaptureOptions& options, const v1::Camera& camera,
                                      const ViewSize& size, LazyBounds& bounds) {
  if (!options.sphere && options.box.empty()) return plan_grid(options, camera, size, bounds);
  const auto around = bounds.get();
  if (!around.ok()) return around.status();
  const Uprightness upright = uprightness_of(camera);
  if (options.sphere) {
    SphereRequest request;
    request.cameras = *options.sphere;
    if (options.target)
      request.target.emplace((*options.target)[0], (*options.target)[1], (*options.target)[2]);
    request.radius = options.radius;
    return plan_sphere(request, *around, upright, options.fov, size);
  }
  BoxRequest request;
  if (options.grid) std::tie(request.columns, request.rows) = *options.grid;
  request.outwards = options.outwards;
  if (options.box != "scene") {
    const auto n = parse_six(options.box);
    if (!n.ok()) return n.status();
    request.box.emplace(Imath::V3d((*n)[0], (*n)[1], (*n)[2]), Imath::V3d((*n)[3], (*n)[4], (*n)[5]));
  }
  return plan_box(request, *around, upright, options.fov, size);
}

/// Free bytes of the disk that the set will be on.
std::uint64_t free_bytes(const std::string& folder) {
  std::error_code error;
  fs::path path = fs::absolute(folder, error);
  while (!fs::exists(path, error) && path.has_relative_path()) path = path.parent_path();
  const fs::space_info space = fs::space(path, error);
  return error ? UINT64_MAX : space.available;
}

light_field::Manifest empty_manifest(const CaptureOptions& options, const CapturePlan& plan) {
  light_field::Manifest manifest;
  manifest.width = options.size.width, manifest.height = options.size.height;
  manifest.tile_size = options.tile_size;
  manifest.half = !options.full_floats;
  manifest.compression = options.compression;
  if (options.compression == light_field::Compression::kDwaa) manifest.dwa_level = options.dwa_level;
  manifest.arrangement = plan.arrangement;
  for (const light_field::Pinhole& camera : plan.cameras) manifest.views.emplace_back().camera = camera;
  return manifest;
}

void tell_set(const light_field::Manifest& manifest, const std::string& folder) {
  std::uint64_t bytes = 0;
  for (const light_field::View& view : manifest.views) bytes += view.file_bytes;
  std::cerr << folder << ": " << manifest.views.size() << " views of " << manifest.width << "x"
            << manifest.height << absl::StreamFormat(", %.4g MB", 1e-6 * static_cast<double>(bytes));
  if (manifest.psnr_db > 0) std::cerr << absl::StreamFormat(", PSNR of DWA %.4g dB", manifest.psnr_db);
  std::cerr << '\n';
}

int render_set(const CaptureOptions& options, LoadedJob& loaded, const CapturePlan& plan, FarmClient* farm,
               Interrupt& interrupt) {
  const ViewSize size{options.size.width, options.size.height};
  v1::Scene& scene = loaded.imported.scene;
  set_cameras(plan.cameras, size, scene);
  ViewJobOptions how{.job = options.scene.job,
                     .name = absl::StrCat("light field of ", loaded.job->spec.farm().name()),
                     .threads = options.scene.threads,
                     .farm = farm,
                     .checkpoint = options.scene.checkpoint,
                     .quiet = options.scene.quiet,
                     .stop = interrupt.token()};
  const auto job = prepare_views(loaded.imported, how);
  if (!job.ok()) return report_view_error(job.status());
  light_field::Manifest manifest = empty_manifest(options, plan);
  manifest.metres = scene.units().metres();
  manifest.provenance = provenance_of((*job)->spec, options.scene);
  SetWriter writer(options.scene.output, manifest);
  if (absl::Status s = writer.begin(); !s.ok()) return report(kUsage, std::string(s.message()));
  auto images = render_views(**job, how);
  if (!images.ok()) return report_view_error(images.status());
  for (std::uint32_t view = 0; view < images->size(); ++view) {
    if (absl::Status s = writer.write(view, (*images)[view]); !s.ok())
      return report(kIncomplete, std::string(s.message()));
    (*images)[view] = {};
  }
  if (absl::Status s = writer.finish(); !s.ok()) return report(kIncomplete, std::string(s.message()));
  if (!options.scene.checkpoint.empty()) {
    if (absl::Status s = delete_checkpoint(options.scene.checkpoint); !s.ok())
      std::cerr << "warning: " << s.message() << '\n';
  }
  if (!options.scene.quiet) tell_set(manifest, options.scene.output);
  return kDone;
}

int capture_set(CaptureOptions options, Interrupt& interrupt) {
  std::unique_ptr<FarmClient> farm;
  if (options.on_farm) {
    auto connected = connect(options.server, options.scene.quiet);
    if (!connected.ok()) return report_farm_error(connected.status(), options.server);
    farm = *std::move(connected);
  }
  options.scene.job.resolution = options.size;
  int exit_code = kDone;
  const ChoiceOptions choice{.threads = options.scene.threads, .stop = [&] { return interrupt.token(); }};
  const std::unique_ptr<LoadedJob> loaded = load_job(options.scene, exit_code, nullptr, &choice);
  if (loaded == nullptr) return exit_code;
  // The choice was made.
  options.scene.job.settings.set_integrator(loaded->job->spec.content().algorithms().integrator());
  drop_picture_settings(loaded->imported);
  LazyBounds bounds(*loaded->job, options.scene.threads);
  const ViewSize size{options.size.width, options.size.height};
  const auto plan = make_plan(options, loaded->imported.scene.camera(), size, bounds);
  if (!plan.ok())
    return report(kUsage, absl::StrCat(options.scene.scene, ": ", std::string(plan.status().message())));
  const absl::Status fits = check_size(plan->cameras.size(), size, !options.full_floats,
                                       free_bytes(options.scene.output), base::available_memory());
  if (!fits.ok()) return report(kUsage, std::string(fits.message()));
  return render_set(options, *loaded, *plan, farm.get(), interrupt);
}

void define_cameras(Command& command, CaptureOptions& options) {
  command.group("Cameras");
  add_parsed(command, "--grid", options.grid, parse_counts,
             "cameras of the grid, or of each face of a box (default: 17x17; 9x9 of a box)")
      .type_name("CxR");
  const Option spacing =
      command.add("--spacing", options.spacing, "between cameras of a grid").type_name("LENGTH");
  command
      .add("--baseline", options.baseline, "from the first to the last camera of a row (default: focus / 5)")
      .type_name("LENGTH")
      .excludes(spacing);
  command
      .add("--focus", options.focus,
           "from the grid to the plane onto which views are sheared (default: to "
           "the scene's middle)")
      .type_name("LENGTH");
  const Option sphere = command.add("--sphere", options.sphere,
                                    "so many cameras on a sphere instead, which look at its middle");
  add_parsed(command, "--target", options.target, parse_triple, "the sphere's middle (default: the scene's)")
      .type_name("X,Y,Z")
      .needs(sphere);
  command.add("--radius", options.radius, "of the sphere").type_name("LENGTH").needs(sphere);
  const Option box = command
                         .add("--box", options.box,
                              "grids on the faces of a box instead, from its least to "
                              "its largest corner, or 'scene': about all of it")
                         .type_name("X,Y,Z,X,Y,Z")
                         .excludes(sphere);
  command.add_flag("--outwards", options.outwards, "cameras of a box look out of it: for eyes within")
      .needs(box);
  command.add("--fov", options.fov, "field of view across the shorter side, degrees (default: the camera's)")
      .in_range(0.01, 175)
      .type_name("DEGREES");
}

void define_files(Command& command, CaptureOptions& options) {
  command.group("Set");
  command.add("-o,--output", options.scene.output, "the folder of the set").type_name("FOLDER").required();
  command
      .add_read_by(
          "--size",
          [&options](const std::string& text) {
            const auto size = parse_resolution(text);
            if (size.ok()) options.size = *size;
            return size.status();
          },
          "of each view (default: 512x512)")
      .type_name("WxH");
  using light_field::Compression;
  add_choice(command, "--compression",
             WordList<Compression>{
                 {"none", Compression::kNone}, {"zip", Compression::kZip}, {"dwaa", Compression::kDwaa}},
             options.compression, "none, zip, or dwaa, with loss, which is told (default: zip)")
      .type_name("NAME");
  command.add("--dwa-level", options.dwa_level, "the loss of dwaa: larger levels make smaller files")
      .in_range(0, 10000)
      .with_default();
  command.add_flag("--float", options.full_floats, "colours of 32 bits, not 16");
  command
      .add_read_by(
          "--tile",
          [&options](const std::string& text) {
            options.tile_size = static_cast<std::uint32_t>(std::stoul(text));
            return absl::OkStatus();
          },
          "side of the files' tiles, pixels (default: 64)")
      .type_name("N")
      .one_of({"16", "32", "64", "128", "256"});
}

}  // namespace

void add_light_field_capture(CommandLine& line) {
  auto options = std::make_shared<CaptureOptions>();
  options->scene.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  Command command = line.add_command("lightfield capture", "Render the views of a light field, in one job");
  command.add("SCENE", options->scene.scene, absl::StrCat("the scene: ", kSceneFiles).c_str()).required();
  define_cameras(command, *options);
  define_files(command, *options);
  define_settings(command, options->scene.job.settings,
                  [](const std::string& name) { return name != "noise" && name != "film"; });
  command.group("Computation");
  command.add("-D", options->scene.defines, "a parameter of the scene; may be repeated")
      .type_name("NAME=VALUE");
  command.add("--threads", options->scene.threads, "tiles rendered at once")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.add("--checkpoint", options->scene.checkpoint, "keep results here; the same command goes on")
      .type_name("FOLDER");
  command.add_flag("--farm", options->on_farm, "on the farm of --server, not in this process");
  define_server_option(command, options->server);
  command.add_flag("--quiet", options->scene.quiet, "no progress, no warnings");
  command.example("tessera lightfield capture box.pbrt -o box.lf --grid 9x9 --spp 64");
  command.example("tessera lightfield capture vase.gltf -o vase.lf --sphere 200");
  command.example("tessera lightfield capture vase.gltf -o vase.lf --box scene");
  command.does([options](Interrupt& interrupt) { return capture_set(*options, interrupt); });
}

}  // namespace tessera::client
