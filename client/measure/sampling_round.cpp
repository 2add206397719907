#include "measure/sampling_round.h"

#include <algorithm>
#include <utility>

namespace tessera::client {

namespace {

/// A job has no more pixels; a film is so wide, or less.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 20;
constexpr std::uint32_t kWidth = 256;

}  // namespace

absl::Status Round::finish(std::optional<std::size_t> integrator, ReadLight light, std::uint64_t& seed) {
  if (pixels_ == 0) return absl::OkStatus();
  ProbeJob job;
  job.camera.Swap(&camera_);
  job.blobs = std::exchange(blobs_, {});
  job.light = light;
  if (integrator) job.integrator = options_.integrators[*integrator];
  job.spp = sampled_.samples_per_pixel;
  job.width = static_cast<std::uint32_t>(std::min<std::uint64_t>(kWidth, pixels_));
  job.height = static_cast<std::uint32_t>((pixels_ + job.width - 1) / job.width);
  job.seed = seed++;
  const auto picture = render_(job);
  if (!picture.ok()) return picture.status();
  if (picture->pixels.size() < pixels_) return absl::InternalError("a picture of probes lacks pixels");
  sampled_.cpu_seconds += picture->cpu_seconds;
  if (light == ReadLight::kAll) sampled_.rays += picture->rays;
  std::size_t pixel = 0;
  for (const CellPixels& run : order_) {
    for (std::uint64_t i = 0; i < run.pixels; ++i) sampled_.cells[run.cell].add(picture->pixels[pixel++]);
  }
  progress_.samples += pixels_ * sampled_.samples_per_pixel;
  if (options_.progress) options_.progress(progress_);
  camera_.Clear(), order_.clear(), pixels_ = 0;
  return absl::OkStatus();
}

/// Adds the probe to the job, without pixels: of a cell that is a triangle, the one of that.
v1::Probe& Round::begin(const PlannedProbe& probe, std::size_t cell) {
  v1::Probe& added = *camera_.add_probes();
  added = probe.probe;
  if (!probe.triangles.empty()) place_on(probe.triangles[cell], added);
  added.mutable_pixels_of_cells()->Resize(probe.triangles.empty() ? static_cast<int>(probe.cells) : 1, 0);
  for (const SceneBlob& blob : probe.blobs) {
    const auto is_it = [&](const SceneBlob& other) { return other.ref.digest() == blob.ref.digest(); };
    if (std::ranges::none_of(blobs_, is_it)) blobs_.push_back(blob);
  }
  return added;
}

absl::Status Round::run(std::optional<std::size_t> integrator, ReadLight light,
                        const std::vector<std::uint64_t>& wanted, std::uint64_t& seed) {
  for (const PlannedProbe& probe : plan_.probes) {
    if (probe.light != light) continue;
    v1::Probe* added = nullptr;
    for (std::size_t i = 0; i < probe.cells; ++i) {
      const std::size_t cell = probe.first_cell + i;
      const bool is_triangle = !probe.triangles.empty();
      if (is_triangle && !(probe.triangles[i].area() > 0)) continue;
      if (is_triangle) added = nullptr;
      std::uint64_t left = wanted[cell];
      while (left > 0) {
        if (pixels_ == kMostPixels) {
          if (absl::Status s = finish(integrator, light, seed); !s.ok()) return s;
          added = nullptr;
          if (time_is_up()) {
            sampled_.stopped = true;
            return absl::OkStatus();
          }
        }
        if (added == nullptr) added = &begin(probe, i);
        const std::uint64_t now = std::min(left, kMostPixels - pixels_);
        added->set_pixels_of_cells(is_triangle ? 0 : static_cast<int>(i), static_cast<std::uint32_t>(now));
        order_.push_back({cell, now});
        pixels_ += now, left -= now;
      }
    }
  }
  return finish(integrator, light, seed);
}

absl::Status Round::run(std::size_t integrator, const std::vector<std::uint64_t>& wanted,
                        std::uint64_t& seed) {
  return run(std::optional(integrator), ReadLight::kAll, wanted, seed);
}

absl::Status Round::run(const std::vector<std::uint64_t>& wanted, std::uint64_t& seed) {
  const bool chosen = !sampled_.integrator_of_cell.empty();
  if (!chosen) {
    if (absl::Status s = run(std::nullopt, ReadLight::kAll, wanted, seed); !s.ok()) return s;
  }
  for (std::size_t i = 0; chosen && i < options_.integrators.size(); ++i) {
    std::vector<std::uint64_t> own = wanted;
    for (std::size_t cell = 0; cell < own.size(); ++cell)
      if (sampled_.integrator_of_cell[cell] != i) own[cell] = 0;
    if (absl::Status s = run(i, own, seed); !s.ok()) return s;
  }
  return run(std::nullopt, ReadLight::kStraight, wanted, seed);
}

}  // namespace tessera::client
