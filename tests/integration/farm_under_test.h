// A farm of real processes on this machine: a coordinator on a free port, workers, clients.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "farm/farm_client.h"
#include "support/patience.h"
#include "support/process/process.h"
#include "support/process/temp_dir.h"

namespace tessera::integration {

/// Paths of the programs under test.
void use_programs_of(const std::string& folder);  // before, they are those of the build
std::string tessera_program();
std::string server_program();
std::string worker_program();

using support::kPatience;

using Arguments = std::vector<std::string>;
Arguments operator+(Arguments a, const Arguments& b);

/// A square picture of cornell-box in small tiles, seconds of work in many units. Its pixels do not
/// share light: tiles that small would have several times as many samples.
Arguments in_many_units(const std::string& side, const std::string& spp, const std::string& tile = "16");

/// Runs `tessera` with these arguments.
support::Finished tessera(std::vector<std::string> arguments);

/// SHA-256 over names and 32-bit values of all channels of an EXR file; metadata is left out. A test failure,
/// and the empty string, when the file cannot be read.
std::string pixel_sha256(const std::filesystem::path& exr);

/// The pixels that every farm must give for `tessera render` with these arguments, as pixel_sha256; rendered
/// here, once.
const std::string& expected_hash(const Arguments& arguments);

/// A number of a JSON file's top level.
double json_number(const std::filesystem::path& file, const std::string& name);

/// How a worker is started.
struct WorkerSetup {
  int threads = 1;
  std::string name = {};                  // its host, too; empty: one that no other has
  std::string server = {};                // another address than the coordinator's own
  std::filesystem::path cache = {};       // empty: one of its own, which stays when it is started again
  std::vector<std::string> wrapper = {};  // a command that runs the worker's
  std::vector<std::string> environment = {};
  Arguments options = {};  // more of the worker's own
};

inline bool a_quarter_is_done(const v1::JobStatus& status) {
  return status.units_total() > 0 && 4 * status.units_done() >= status.units_total();
}

class FarmUnderTest {
 public:
  /// `wrapper` is a command that runs the coordinator's; `environment` is added to its own, and `options` to
  /// those of its command. It listens on a free port of `host`, without encryption.
  explicit FarmUnderTest(std::vector<std::string> wrapper = {}, std::vector<std::string> environment = {},
                         const std::string& host = "127.0.0.1", Arguments options = {});

  /// Directory for what the test writes.
  const std::filesystem::path& directory() const { return directory_.path(); }
  const std::string& address() const { return address_; }

  support::Process& add_worker(WorkerSetup setup);
  /// With a cache of its own.
  support::Process& add_worker(int threads, std::string name = {});
  support::Process& worker(std::size_t index) { return *workers_[index].process; }
  void kill_worker(std::size_t index);
  /// After its end: the same command again.
  support::Process& restart_worker(std::size_t index);
  const std::filesystem::path& cache_of(std::size_t index) const { return workers_[index].setup.cache; }

  support::Process& coordinator() { return *coordinator_; }
  std::filesystem::path data_dir() const { return directory() / "coordinator"; }
  void kill_coordinator();
  /// After its end: the same data directory and port again.
  void restart_coordinator() { start_coordinator(address_); }
  void kill_and_restart_coordinator();
  /// One of the workers, or the coordinator, is killed at whatever it is at, and started again.
  void kill_somebody(std::mt19937_64& random);

  /// Arguments of `tessera` that run on this farm.
  std::vector<std::string> on_farm(std::vector<std::string> arguments) const;

  /// `tessera submit --detach` with these arguments; the job's id.
  std::string submit_detached(std::vector<std::string> arguments);

  /// `tessera fetch`; the hash of the image's pixels.
  std::string fetch_hash(const std::string& job_id);

  /// Watches until `enough` says so of a status, or the job's end. Returns that status; adds the units whose
  /// results have come to `acknowledged`, when it is given. A failure of the test when neither has come after
  /// five minutes.
  v1::JobStatus watch_until(const std::string& job_id,
                            const std::function<bool(const v1::JobStatus&)>& enough,
                            std::set<std::uint32_t>* acknowledged = nullptr);

  /// Watches until the job's end; units that were set aside for too many deaths are tried again, how often
  /// is added to `retries`.
  v1::JobStatus watch_to_the_end(const std::string& job_id, int* retries = nullptr);

  /// Client for the thread that holds this object.
  client::FarmClient& client() { return *client_; }
  /// One more, for another thread.
  std::unique_ptr<client::FarmClient> new_client() const;

 private:
  struct Worker {
    WorkerSetup setup;
    std::unique_ptr<support::Process> process;
  };

  void start_coordinator(const std::string& listen);
  std::unique_ptr<support::Process> start_worker(const WorkerSetup& setup) const;

  support::TempDir directory_;
  const std::vector<std::string> wrapper_, environment_, options_;  // the coordinator's
  std::string address_;
  std::unique_ptr<support::Process> coordinator_;
  std::vector<Worker> workers_;
  std::unique_ptr<client::FarmClient> client_;
};

}  // namespace tessera::integration
