// A Slurm cluster on this machine: Debian's munged, slurmctld and one slurmd for each of two nodes, in a
// directory and on ports of its own. Needs no rights: everything runs as whoever runs the test.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "support/process/process.h"
#include "support/process/temp_dir.h"

namespace tessera::cluster {

/// A batch job that is over, or not known any more.
struct JobEnd {
  std::string state;   // "COMPLETED", "FAILED", "CANCELLED"
  int exit_code = -1;  // exit code of the script
};

/// Nodes `one` and `two` have as many CPUs each as the machine. Jobs of the partition `high` preempt those of
/// `low`, the default, which are requeued after some seconds.
class SlurmCluster {
 public:
  /// Parts of Slurm that are not installed; empty when all is there.
  static std::string missing();

  /// Throws std::runtime_error, with the daemons' logs, when the nodes do not become idle.
  SlurmCluster();
  /// Ends the jobs first.
  ~SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  /// Runs one of Slurm's commands, with `NAME=VALUE` added to its environment; its stdout. A failure of the
  /// test when it fails.
  std::string run(std::vector<std::string> command, std::vector<std::string> environment = {}) const;

  /// sbatch with these arguments; the job's id.
  std::string submit(std::vector<std::string> arguments, std::vector<std::string> environment = {}) const;
  /// "RUNNING", "PENDING" and so on; empty for a job that Slurm does not know (any more).
  std::string state_of(const std::string& job) const;
  bool is_over(const std::string& job) const;
  /// Nothing when the job is not over within `patience`.
  std::optional<JobEnd> wait_for_end(const std::string& job, std::chrono::seconds patience) const;

 private:
  support::Finished execute(std::vector<std::string> command,
                            std::vector<std::string> environment = {}) const;
  std::string field(const std::string& job, const std::string& name) const;

  support::TempDir directory_;
  std::vector<std::unique_ptr<support::Process>> daemons_;
};

}  // namespace tessera::cluster
