// Results of a job's phases, for units that read them: fetched and read once, however many units need them.
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "agent/link/coordinator_link.h"
#include "agent/stores/blob_fetcher.h"
#include "agent/stores/scene_store.h"
#include "base/clock.h"
#include "render/renderer.h"
#include "tessera/v1/job.pb.h"

namespace tessera::agent {

/// Blobs that a unit reads, for as long as this is there.
struct Inputs {
  std::vector<render::BlobBytes> blobs;
  std::vector<std::string_view> blob_contents;
};

/// Thread-safe.
class PreparedStore {
 public:
  /// Without a fetcher, blobs are kept in memory alone.
  PreparedStore(base::Clock& clock, CoordinatorLink& link, BlobFetcher* fetcher)
      : link_(link), fetcher_(fetcher), changed_(clock) {}

  /// The blobs that the unit reads. Cancelled when `stop` is requested.
  absl::StatusOr<Inputs> fetch(const std::string& job_id, const v1::WorkUnit& unit, std::stop_token stop);

  /// The blobs that the unit reads, as its scene's algorithm prepares them; null where it reads none. The
  /// first caller prepares, on its own thread, and the others wait. Kept for the jobs that were asked for
  /// last.
  absl::StatusOr<std::shared_ptr<const render::Prepared>> get(const std::string& job_id,
                                                              const v1::WorkUnit& unit,
                                                              const std::shared_ptr<const LoadedScene>& scene,
                                                              std::stop_token stop);

  /// The job is over: what only it has read is dropped, from memory and from the disk.
  void drop(const std::string& job_id);

 private:
  static constexpr std::size_t kKept = 4;

  struct Slot {
    std::vector<std::string> digests;
    std::shared_ptr<const LoadedScene> scene;  // outlives what was prepared for it
    Inputs inputs;
    std::shared_ptr<const render::Prepared> prepared;  // null while it is made
  };
  static std::shared_ptr<const render::Prepared> whole(const std::shared_ptr<Slot>& slot);
  absl::StatusOr<render::BlobBytes> fetch(const std::string& digest, std::stop_token stop);

  CoordinatorLink& link_;
  BlobFetcher* const fetcher_;
  std::mutex mutex_;
  base::Condition changed_;
  std::list<std::shared_ptr<Slot>> slots_;             // the last asked for first
  std::map<std::string, std::set<std::string>> read_;  // digests by job
};

}  // namespace tessera::agent
