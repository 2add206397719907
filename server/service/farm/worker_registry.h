// The workers of the farm: who they are, and whether they are heard of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "service/farm/done.h"
#include "service/farm/worker_origin.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

class FarmCore;

/// Thread-safe. The core must outlive it.
class WorkerRegistry {
 public:
  // A registration stays for as long as its worker, and all of them go into one answer (ListWorkers).
  static constexpr std::size_t kMaxNameBytes = 256;

  struct Registration {
    std::shared_ptr<const Accounts::Hold> account;
    std::uint64_t failures = 0, resident_bytes = 0;  // shown to people
  };

  explicit WorkerRegistry(FarmCore& core) : core_(core) {}

  /// FailedPrecondition for a worker of another build or protocol, InvalidArgument for names, classes or
  /// threads that are not taken, Unavailable when the farm stops.
  absl::StatusOr<v1::RegisterResponse> register_worker(const v1::RegisterRequest& request,
                                                       const WorkerOrigin& origin = {});
  /// NotFound as check() has it, Unavailable when the farm stops.
  absl::Status deregister(const std::string& worker, const WorkerOrigin& origin = {});
  /// Workers that registered with a certificate of this name leave at once; others get what they had leased.
  /// How many that were.
  std::uint32_t expel(const std::string& certificate);
  /// Lifts the quarantine of a host. NotFound and FailedPrecondition as Scheduler::trust_host has them,
  /// Unavailable when the farm stops.
  void trust_host(const std::string& host, DoneEmpty done);

  // With the farm's lock held.

  /// NotFound for a worker that is not known, or was registered by the holder of another key.
  absl::Status check(const std::string& worker, const WorkerOrigin& origin) const;
  /// Null for a worker that is not known.
  const Registration* find(const std::string& worker) const;
  void note_failure(const std::string& worker);
  void note_memory(const std::string& worker, std::uint64_t resident_bytes);
  /// Gives up workers and leases that were not heard of for too long.
  void give_up_lost();

 private:
  FarmCore& core_;
  absl::flat_hash_map<std::string, Registration> registrations_by_worker_;
};

}  // namespace tessera::server
