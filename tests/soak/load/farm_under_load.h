// A real coordinator in a process of its own, what it is loaded with, and what that costs it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "farm/farm_client.h"
#include "soak/load/stub_fleet.h"
#include "support/process/process.h"
#include "support/process/temp_dir.h"

namespace tessera::load {

/// Resources that a process has used so far, from /proc.
struct ProcessUse {
  std::chrono::milliseconds cpu{0};
  std::uint64_t resident_bytes = 0;
  std::uint64_t peak_resident_bytes = 0;
};

struct JobsOptions {
  std::size_t jobs = 4;
  std::size_t users = 2;        // take turns at submitting
  std::size_t scenes = 2;       // likewise
  std::uint32_t units = 100;    // units of each job, rounded up to a square
  std::uint32_t tile_size = 8;  // pixels
};

/// How many units of each job were done. Thread-safe once all jobs are added.
class Progress {
 public:
  void add(const std::string& job, std::uint32_t units);
  /// A result was acknowledged; only the first one of a unit counts.
  void completed(const std::string& job, std::uint32_t unit);

  std::uint64_t done() const { return done_; }
  std::uint64_t wanted() const { return wanted_; }
  bool all_done() const { return done_ >= wanted_; }
  /// The first job has ended: from here on shares are not equal any more.
  bool one_is_done() const { return one_is_done_; }
  /// Progress of the jobs when the first of them was done, or now.
  std::vector<std::uint64_t> shares() const;

 private:
  struct Job {
    std::vector<std::atomic<bool>> units;  // done?
    std::atomic<std::size_t> done{0};
  };
  std::map<std::string, Job> jobs_;
  std::uint64_t wanted_ = 0;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<bool> one_is_done_{false};
  mutable std::mutex mutex_;
  std::vector<std::uint64_t> shares_;
};

/// Writes a journal as a coordinator leaves it that was killed when all units of a job but one were done. The
/// job's id. Throws where it cannot be written.
std::string write_journal(const std::filesystem::path& data_dir, std::uint32_t units);

class FarmUnderLoad {
 public:
  /// Starts the coordinator's program with `arguments` besides where to listen and to keep its data;
  /// `prepare` fills the data directory, `wrapper` is a command that runs the program's. Throws where it does
  /// not start.
  explicit FarmUnderLoad(std::string server_program, std::vector<std::string> arguments = {},
                         const std::function<void(const std::filesystem::path&)>& prepare = {},
                         std::vector<std::string> wrapper = {});

  const std::string& address() const { return address_; }
  pid_t process_id() const { return process_->id(); }
  client::FarmClient& client() { return *client_; }

  /// Uploads the scenes, and submits jobs that have nothing else in common. Their ids, or the first error.
  absl::StatusOr<std::vector<std::string>> submit(const JobsOptions& options, Progress& progress);

  ProcessUse use() const;

  /// kill -9, and the same data directory and port again; how long it takes until calls are served.
  std::chrono::milliseconds kill_and_restart();

  /// Ends it the ordinary way.
  void stop();

 private:
  void start(const std::string& listen);

  const std::string program_;
  const std::vector<std::string> arguments_, wrapper_;
  support::TempDir directory_;
  std::string address_;
  std::unique_ptr<support::Process> process_;
  std::unique_ptr<client::FarmClient> client_;
};

}  // namespace tessera::load
