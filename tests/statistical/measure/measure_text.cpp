#include "measure_text.h"

#include <fstream>
#include <optional>

#include "command/measure/probe_jobs.h"
#include "import/import.h"
#include "measure/measure.h"
#include "support/process/temp_dir.h"

namespace tessera::test {

namespace {

using support::TempDir;

std::string write(const TempDir& folder, const std::string& name, const std::string& text) {
  const std::string path = (folder.path() / name).string();
  std::ofstream(path) << text;
  return path;
}

}  // namespace

absl::StatusOr<client::Measured> measure_text(const MeasureRequest& request) {
  const TempDir folder;
  auto imported = client::import_scene(write(folder, "scene.textproto", request.scene), {});
  if (!imported.ok()) return imported.status();
  const auto file = client::read_meter_file(write(folder, "meters.textproto", request.meters));
  if (!file.ok()) return file.status();
  std::optional<absl::StatusOr<client::Ball>> ball;
  auto scene =
      client::measured_scene(*imported, *file, request.is_spectral, [&]() -> absl::StatusOr<client::Ball> {
        if (!ball) ball = client::ball_around(*imported, 1);
        return *ball;
      });
  if (!scene.ok()) return scene.status();
  scene->emitted_flux = [&](const v1::Scene& lights) { return client::emitted_flux(*imported, lights, 1); };
  const auto plan = client::plan_of(*file, *scene);
  if (!plan.ok()) return plan.status();
  client::ProbeJobOptions how{.name = "test", .threads = request.threads};
  how.job.settings.set_integrator(request.algorithm);
  if (request.is_spectral) how.job.settings.set_color(v1::COLOR_SPECTRAL);
  client::ProbeJobs jobs(*imported, how);
  client::SamplingOptions sampling{.samples = request.samples,
                                   .error = request.error,
                                   .seed = request.seed,
                                   .integrators = request.integrators};
  const auto run =
      client::measure(*plan, *scene, *file, request.algorithm, sampling,
                      {[&](const client::ProbeJob& job) { return jobs.render(job); },
                       [&](const client::PictureJob& job) { return jobs.render(job); },
                       [&](const client::ProbeJob& job, const v1::Light& light, std::string sky) {
                         return jobs.render(job, light, std::move(sky));
                       }});
  if (!run.ok()) return run.status();
  return run->measured;
}

std::string scene_with(const std::string& more, const std::string& medium, double cd_per_m2) {
  return "camera { medium: '" + medium + R"(' orthographic {} } film { width: 1 height: 1 }
      materials { name: 'black' diffuse { reflectance { constant { rgb {} } } } }
      materials { name: 'white' diffuse { reflectance { constant { rgb { r: 1 g: 1 b: 1 } } } } }
      shapes { disk { radius: 0.001 } material: 'black' name: 'far'
               world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-40, 0,0,0,1] } }
      units { metres: 1 cd_per_m2: )" +
         std::to_string(cd_per_m2) + " } " + more;
}

}  // namespace tessera::test
