// A farm of real processes on this machine: a coordinator on a free port, workers, clients.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "farm/farm_client.h"
#include "support/process.h"
#include "support/temp_dir.h"

namespace tessera::integration {

/// Paths of the programs under test.
std::string tessera_program();
std::string server_program();
std::string worker_program();

/// Longest time that anything in these tests may take; reached only when it hangs.
inline constexpr std::chrono::seconds kPatience{60};

/// Runs `tessera` with these arguments.
support::Finished tessera(std::vector<std::string> arguments);

/// SHA-256 over names and 32-bit values of all channels of an EXR file; metadata is left out. A test failure, and
/// the empty string, when the file cannot be read.
std::string pixel_sha256(const std::filesystem::path& exr);

/// A number of a JSON file's top level.
double json_number(const std::filesystem::path& file, const std::string& name);

class FarmUnderTest {
 public:
  FarmUnderTest();

  /// Directory for what the test writes.
  const std::filesystem::path& directory() const { return directory_.path(); }
  const std::string& address() const { return address_; }

  /// Starts a worker with a cache of its own. Its name is that of its host, too; empty: one that no other has.
  support::Process& add_worker(int threads, std::string name = {});
  support::Process& worker(std::size_t index) { return *workers_[index]; }

  /// kill -9, and the same data directory and port again.
  void kill_and_restart_coordinator();

  /// Arguments of `tessera` that run on this farm.
  std::vector<std::string> on_farm(std::vector<std::string> arguments) const;

  /// `tessera submit --detach` with these arguments; the job's id.
  std::string submit_detached(std::vector<std::string> arguments);

  /// `tessera fetch`; the hash of the image's pixels.
  std::string fetch_hash(const std::string& job_id);

  /// Watches until `enough` says so of a status, or the job's end. Returns that status; adds the units whose results have
  /// come to `acknowledged`, when it is given.
  v1::JobStatus watch_until(const std::string& job_id, const std::function<bool(const v1::JobStatus&)>& enough,
                            std::set<std::uint32_t>* acknowledged = nullptr);

  client::FarmClient& client() { return *client_; }

 private:
  void start_coordinator(const std::string& listen);

  support::TempDir directory_;
  std::string address_;
  std::unique_ptr<support::Process> coordinator_;
  std::vector<std::unique_ptr<support::Process>> workers_;
  std::unique_ptr<client::FarmClient> client_;
};

}  // namespace tessera::integration
