// tessera radiosity SCENE -o MESH: the light of a scene's surfaces, as a mesh.
#include <iostream>
#include <memory>

#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/render_options.h"
#include "command/report/output.h"
#include "command/setting_options.h"
#include "image/atomic_file.h"
#include "local/bench_scene.h"
#include "mesh/mesh_file.h"

namespace tessera::client {
namespace {

int write_radiosity(RenderOptions options, Interrupt& interrupt) {
  absl::Status status = check_mesh_path(options.output);
  if (status.ok()) status = check_writable(options.output);
  if (!status.ok()) return report(kUsage, std::string{status.message()});
  options.job.settings.set_integrator("radiosity");
  int exit_code = kDone;
  const std::unique_ptr<LoadedJob> loaded = load_job(options, exit_code);
  if (loaded == nullptr) return exit_code;
  const auto scene = build_scene(*loaded, options);
  if (!scene.ok()) return report(kBadScene, std::string{scene.status().message()});
  const absl::StatusOr<LitMesh> mesh = (*scene)->radiosity_mesh(loaded->imported.scene, interrupt.token());
  if (!mesh.ok()) {
    return report(absl::IsCancelled(mesh.status()) ? kInterrupted : kJobFailed,
                  std::string{mesh.status().message()});
  }
  const absl::StatusOr<std::string> bytes = mesh_bytes(*mesh, options.output);
  status = bytes.ok() ? replace_file_with(options.output, *bytes) : bytes.status();
  if (!status.ok()) return report(kIncomplete, std::string{status.message()});
  if (!options.quiet) {
    std::cerr << options.output << ": " << mesh->triangles.size() << " patches, " << mesh->positions.size()
              << " vertices\n";
  }
  return kDone;
}

}  // namespace

void add_radiosity_command(CommandLine& line) {
  auto options = std::make_shared<RenderOptions>();
  Command command = line.add_command("radiosity", "Write the light of a scene's surfaces as a mesh");
  command.add("SCENE", options->scene, absl::StrCat("the scene: ", kSceneFiles).c_str()).required();
  command.group("Mesh");
  command.add("-o,--output", options->output, "the mesh: .ply (W/m^2) or .glb (COLOR_0)")
      .type_name("FILE")
      .required();
  define_settings(command, options->job.settings,
                  [](const std::string& name) { return name.starts_with("radiosity."); });
  command.group("Output");
  command.add_flag("--quiet", options->quiet, "no progress, no warnings");
  command.example("tessera radiosity scenes/cornell-box/scene.pbrt -o box.glb");
  command.does([options](Interrupt& interrupt) { return write_radiosity(*options, interrupt); });
}

}  // namespace tessera::client
