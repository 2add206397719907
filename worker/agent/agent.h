// The worker: leases units from a coordinator, renders them, and brings the results home.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "base/clock.h"
#include "render/scene/load_scene.h"

namespace tessera::agent {

class CoordinatorLink;

/// Builds a scene: render::load_scene, or what a test puts in its place.
using SceneLoader = std::function<absl::StatusOr<std::unique_ptr<render::RenderScene>>(
    const v1::Scene&, const v1::JobSpec&, const render::BlobSource&, const render::LoadOptions&)>;

struct AgentOptions {
  std::string name;               // shown to people
  std::string host;               // name that stays over restarts: faults are counted by it; empty: `name`
  std::vector<std::string> tags;  // tags that jobs may require
  int threads = 1;                // number of tiles rendered at once
  std::vector<std::string> isas;  // instruction sets that this worker may use, best first
  // How it rounds with each of them (render::arithmetic_classes); empty: nothing is known of it but the ISAs.
  std::vector<std::string> arithmetic_classes = {};
  SceneLoader load_scene;
  // The coordinator is in this process, and keeps results in its memory: they need no compression.
  bool plain_results = false;
  // Where the blobs come from; empty: from the coordinator, through a cache in `cache_dir`.
  render::BlobSource blobs;
  std::filesystem::path cache_dir;
  std::uint64_t cache_cap_bytes = std::uint64_t{64} << 30;
  // Scenes stay loaded for jobs to come, those used last.
  std::size_t scenes_kept = 16;
  std::size_t scene_memory_cap_bytes = 0;  // beside the last; 0: half of the machine's memory
  std::chrono::milliseconds unit_limit{
      0};  // longer than this no unit may take, its scene not counted; 0: any time
  // After a request to stop: how long units may take to finish and results to arrive.
  std::chrono::milliseconds grace{1000};
  // The last lines of this program's log that concern a job: they go with its units' failures. May be empty.
  std::function<std::vector<std::string>(const std::string& job_id)> recent_log = {};
  base::Clock* clock = &base::machine_clock();  // outlives the agent
};

/// Counts of what an agent has done so far.
struct AgentReport {
  std::uint64_t units_rendered = 0;
  std::uint64_t units_failed = 0;
  std::uint64_t units_stopped = 0;      // begun, and revoked or out of the grace period
  std::uint64_t units_handed_back = 0;  // units that were not begun when the agent stopped
  double rendered_unit_seconds = 0;
  /// One count for each bucket of telemetry::kUnitSecondsBuckets, and one for the units that took longer.
  std::vector<std::uint64_t> units_by_seconds;
  std::uint64_t results_acknowledged = 0;
  std::uint64_t outbox_results = 0;  // being sent, or waiting to be sent
  std::uint64_t outbox_bytes = 0;
  std::uint64_t cache_hits = 0;  // blobs that were there
  std::uint64_t cache_misses = 0;
  std::uint64_t cache_bytes = 0;
  std::uint64_t downloaded_bytes = 0;
  std::uint64_t referenced_bytes =
      0;  // blobs of all scenes loaded, those included that were there or were not needed
  std::uint64_t scenes_loaded = 0;
  std::uint64_t scenes_shared = 0;  // loaded with the geometry, BVH and textures of another scene
  double load_seconds = 0;          // fetching blobs and building scenes
  /// The part of load_seconds that building took. Most blobs are fetched meanwhile.
  double build_seconds = 0;
  std::size_t scene_bytes = 0;  // held by the largest scene
  std::size_t scenes_held = 0;
  std::size_t scene_bytes_held = 0;  // sum over scenes_held
};

class Agent {
 public:
  /// FailedPrecondition when there is no ISA to work with or the cache directory cannot be used.
  static absl::StatusOr<std::unique_ptr<Agent>> create(std::unique_ptr<CoordinatorLink> link,
                                                       AgentOptions options);
  ~Agent();

  /// Works until `stop` is requested or the coordinator asks this worker to drain: then finishes what it has
  /// begun within the grace period, gives the rest back and returns OK. Outlives any restart of the
  /// coordinator. An error means that the coordinator refuses this worker. Call it once.
  absl::Status run(std::stop_token stop);

  /// Thread-safe.
  AgentReport report() const;

 private:
  class Work;
  explicit Agent(std::unique_ptr<Work> work);
  std::unique_ptr<Work> work_;
};

}  // namespace tessera::agent
