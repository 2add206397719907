// How long jobs that are over, and the blobs that they named, are kept.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "service/farm/lived_time.h"
#include "service/farm/retention.h"
#include "service/job/job_table.h"
#include "store/blobs/blob_store.h"

namespace tessera::server {

/// Says which jobs are old, and deletes blobs that no job needs. Not thread-safe: the farm's lock is held
/// with every call. What takes its time runs on threads of its own.
class JobKeeper {
 public:
  using StateOf = std::function<v1::JobState(const JobEntry&)>;

  /// Store and clock must outlive the keeper. `lived_time`: the file of LivedTime; empty: none.
  JobKeeper(const Retention& retention, BlobStore& blobs, base::Clock& clock,
            std::filesystem::path lived_time);

  /// Lets a moment of the retention's clock pass.
  void live_on();
  /// How long ago the job ended; the first call is the moment of its end.
  Time since_end_of(const std::string& job) { return lived_.since_end_of(job); }
  /// The job is deleted.
  void forget(const std::string& job) { lived_.forget(job); }

  /// Whether Retention::interval is over since this was true the last time.
  bool is_due();
  /// Jobs whose time is over.
  std::vector<std::string> old_jobs(const JobTable& jobs, const StateOf& state_of);
  /// Lets the next clean_up delete these blobs, which no job refers to, unless somebody asked for them within
  /// `unused`.
  void drop_unused(std::vector<std::string> blobs, std::chrono::seconds unused);
  /// Deletes blobs that no job refers to, if `jobs_went` or it was long ago; and notes how long it lived.
  void clean_up(const JobTable& jobs, bool jobs_went);
  /// Notes how long it lived, before it returns.
  void stop();

 private:
  Time now() const;
  void collect_blobs(const JobTable& jobs);
  void drop_blobs();

  const Retention retention_;
  BlobStore& blobs_;
  base::Clock& clock_;
  LivedTime lived_;
  Time next_look_{}, next_collection_, next_saving_{};
  Time no_collection_before_{};
  std::vector<std::string> blobs_to_drop_;
  std::chrono::seconds unused_for_{0};
  std::atomic<bool> collecting_ = false, saving_ = false;
  base::Thread collector_, saver_;
};

}  // namespace tessera::server
