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

struct MeasuredText::State {
  TempDir folder;
  client::ImportedScene imported;
  client::MeterFile file;
  std::optional<absl::StatusOr<client::Ball>> ball;
  std::optional<client::MeasuredScene> scene;
  client::MeasurePlan plan;
  std::unique_ptr<client::ProbeJobs> jobs;
  std::string algorithm;
  double error = 0;
  std::vector<std::string> integrators;
};

MeasuredText::MeasuredText(std::unique_ptr<State> state) : state_(std::move(state)) {}
MeasuredText::~MeasuredText() = default;

absl::StatusOr<std::unique_ptr<MeasuredText>> MeasuredText::open(const MeasureRequest& request) {
  auto state = std::make_unique<State>();
  State& s = *state;
  for (const auto& [name, bytes] : request.files) write(s.folder, name, bytes);
  auto imported = client::import_scene(write(s.folder, "scene.textproto", request.scene), {});
  if (!imported.ok()) return imported.status();
  s.imported = *std::move(imported);
  auto file = client::read_meter_file(write(s.folder, "meters.textproto", request.meters));
  if (!file.ok()) return file.status();
  s.file = *std::move(file);
  const auto ball = [&s]() -> absl::StatusOr<client::Ball> {
    if (!s.ball) s.ball = client::ball_around(s.imported, 1);
    return *s.ball;
  };
  auto scene = client::measured_scene(s.imported, s.file, request.is_spectral, ball);
  if (!scene.ok()) return scene.status();
  s.scene.emplace(*std::move(scene));
  s.scene->emitted_flux = [&s](const v1::Scene& lights) {
    return client::emitted_flux(s.imported, lights, 1);
  };
  auto plan = client::plan_of(s.file, *s.scene);
  if (!plan.ok()) return plan.status();
  s.plan = *std::move(plan);
  client::ProbeJobOptions how{.name = "test", .threads = request.threads};
  how.job.settings.set_integrator(request.algorithm);
  if (request.is_spectral) how.job.settings.set_color(v1::COLOR_SPECTRAL);
  s.jobs = std::make_unique<client::ProbeJobs>(s.imported, how);
  s.algorithm = request.algorithm;
  s.error = request.error;
  s.integrators = request.integrators;
  return std::unique_ptr<MeasuredText>(new MeasuredText(std::move(state)));
}

absl::StatusOr<client::Measured> MeasuredText::measure(std::uint64_t samples, std::uint64_t seed) {
  State& s = *state_;
  const client::SamplingOptions sampling{
      .samples = samples, .error = s.error, .seed = seed, .integrators = s.integrators};
  auto run = client::measure(s.plan, *s.scene, s.file, s.algorithm, sampling,
                             {[&](const client::ProbeJob& job) { return s.jobs->render(job); },
                              [&](const client::PictureJob& job) { return s.jobs->render(job); },
                              [&](const client::ProbeJob& job, const v1::Light& light, std::string sky) {
                                return s.jobs->render(job, light, std::move(sky));
                              }});
  if (!run.ok()) return run.status();
  return std::move(run->measured);
}

absl::StatusOr<client::Measured> measure_text(const MeasureRequest& request) {
  const auto opened = MeasuredText::open(request);
  if (!opened.ok()) return opened.status();
  return (*opened)->measure(request.samples, request.seed);
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
