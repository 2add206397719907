// Cost of a render, as a JSON file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "command/report/time_spent.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

struct RenderStatistics {
  double load_seconds = 0;              // import and digests
  std::optional<double> build_seconds;  // time to build the scene in this process's worker
  double render_wall_seconds = 0;
  std::uint64_t uploaded_bytes = 0;
  std::vector<std::string> import_warnings;
  v1::JobSpec spec;
  v1::JobStatus status;
  TimeSpent time;
};

/// An object with "load_seconds", "build_seconds" (in-process only), "render_wall_seconds",
/// "render_cpu_seconds" (summed over workers), "rays" {"camera", "bounce", "shadow", "total"}, "samples",
/// "dropped_samples", "counts" (all of wire/render_counts.h), "fireflies" {"samples", "share_of_light"},
/// "units_adopted", "cpu_seconds" (by stage), "shading_seconds", "material_seconds", "scene_bytes",
/// "blob_bytes_fetched", "peak_memory_bytes" (of this process), "spp", "noise", "width", "height", "isa",
/// "scene_digest", "uploaded_bytes", "warnings", "notes"; "auto" (choice_text.h) where the integrator was
/// chosen.
absl::Status write_statistics(const RenderStatistics& statistics, const std::string& path);

}  // namespace tessera::client
