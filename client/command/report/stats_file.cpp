#include "command/report/stats_file.h"

#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "command/report/choice_text.h"
#include "image/atomic_file.h"
#include "wire/job_check.h"
#include "wire/unit_counts.h"

namespace tessera::client {
namespace {

/// The most memory that this process ever held.
std::uint64_t peak_memory_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

nlohmann::ordered_json json_of(const std::vector<TimePart>& parts) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const TimePart& part : parts) json[part.name] = part.seconds;
  return json;
}

/// Bytes of everything that the job refers to.
std::uint64_t scene_bytes(const v1::JobSpec& spec) {
  std::uint64_t bytes = 0;
  for (const v1::BlobRef& blob : spec.farm().blobs()) bytes += blob.size_bytes();
  return bytes;
}

}  // namespace

absl::Status write_statistics(const RenderStatistics& statistics, const std::string& path) {
  const v1::UnitStats& counts = statistics.status.stats();
  std::vector<std::string> warnings = statistics.import_warnings;
  warnings.insert(warnings.end(), counts.warnings().begin(), counts.warnings().end());

  nlohmann::ordered_json json;
  json["load_seconds"] = statistics.load_seconds;
  if (statistics.build_seconds) json["build_seconds"] = *statistics.build_seconds;
  json["render_wall_seconds"] = statistics.render_wall_seconds;
  json["render_cpu_seconds"] = static_cast<double>(counts.cpu_time().seconds()) +
                               1e-9 * static_cast<double>(counts.cpu_time().nanos());
  const wire::RenderCounts render_counts = wire::counts_of(counts);
  for (const wire::RenderCount& count : wire::kRenderCounts) {
    std::visit([&](auto member) { json["counts"][count.name] = render_counts.*member; }, count.member);
  }
  json["rays"] = {{"camera", counts.camera_rays()},
                  {"bounce", counts.bounce_rays()},
                  {"shadow", counts.shadow_rays()},
                  {"total", render_counts.rays()}};
  json["samples"] = counts.samples();
  json["dropped_samples"] = counts.dropped_samples();
  json["cpu_seconds"] = json_of(statistics.time.stages);
  json["cpu_seconds"]["total"] = statistics.time.seconds;
  json["shading_seconds"] = json_of(statistics.time.shading);
  json["material_seconds"] = json_of(statistics.time.materials);
  json["scene_bytes"] = scene_bytes(statistics.spec);
  json["blob_bytes_fetched"] = counts.blob_bytes_fetched();
  json["fireflies"] = {
      {"samples", counts.fireflies()},
      {"share_of_light", counts.light() > 0 ? counts.firefly_light() / counts.light() : 0.0}};
  json["units_adopted"] = statistics.status.units_adopted();
  json["units_unconfirmed"] = statistics.status.units_unconfirmed();
  json["peak_memory_bytes"] = peak_memory_bytes();
  json["spp"] = statistics.spec.samples().spp();
  json["noise"] = statistics.spec.samples().noise();
  json["width"] = statistics.spec.view().width();
  json["height"] = statistics.spec.view().height();
  const std::string& integrator = statistics.spec.content().algorithms().integrator();
  json["integrator"] = integrator;
  json["integrator_kind"] = wire::kind_of(statistics.spec.content().algorithms());
  if (statistics.spec.farm().has_auto_choice()) json["auto"] = choice_json(statistics.spec);
  json["isa"] = statistics.status.isa();
  json["scene_digest"] = statistics.spec.content().scene();
  json["uploaded_bytes"] = statistics.uploaded_bytes;
  json["warnings"] = warnings;
  json["notes"] = std::vector<std::string>(counts.notes().begin(), counts.notes().end());
  // Names and messages may hold bytes that are not UTF-8.
  const auto replace = nlohmann::ordered_json::error_handler_t::replace;
  return replace_file_with(path, json.dump(2, ' ', false, replace) + "\n");
}

}  // namespace tessera::client
