// A coordinator for tests of the agent: hands out a list of units, collects results, and misbehaves on
// request.
#pragma once

#include <grpcpp/support/status_code_enum.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "tessera/v1/work.pb.h"

namespace grpc {
class Channel;
}

namespace tessera::agent {

class FakeCoordinator {
 public:
  FakeCoordinator();
  ~FakeCoordinator();

  std::shared_ptr<grpc::Channel> channel();

  /// Adds a blob and returns its digest. With `corrupt_downloads`, so many downloads deliver other bytes;
  /// with `break_after`, the first download ends UNAVAILABLE after so many bytes.
  std::string add_blob(std::string bytes, int corrupt_downloads = 0, std::size_t break_after = 0);

  /// Offers `count` units of 4x4 pixels, indices from `first`, of a job with this spec.
  void offer(const std::string& job_id, const v1::JobSpec& spec, std::uint32_t first, std::uint32_t count);

  void refuse_registration(std::string message);
  /// Said to workers that register from now on.
  void set_heartbeat_interval(std::chrono::milliseconds interval);
  /// The next `count` Complete calls are answered with this code.
  void fail_completes(int count, grpc::StatusCode code = grpc::StatusCode::UNAVAILABLE);
  /// The next `count` calls of Lease and Register are answered as gRPC answers bytes that it cannot parse.
  void misread(int count);
  /// All registrations are forgotten, as after a restart.
  void forget_workers();
  /// From now on the first heartbeat of each registration is answered after so long.
  void hold_introductions(std::chrono::milliseconds time);
  /// The next heartbeat that carries this unit is told that it is revoked.
  void revoke(std::uint32_t unit_index);
  /// The same for heartbeats that come with a result.
  void revoke_with_result(std::uint32_t unit_index);
  void ask_to_drain();
  /// From now on each result brings a unit more than was asked for.
  void be_generous();

  // Each waits, at most 20 s, for the event, and is false when it did not come.
  bool wait_for_results(std::size_t count);
  bool wait_for_leased(std::size_t count);
  bool wait_for_failures(std::size_t count);
  bool wait_for_deregistration();
  /// A heartbeat that carries so many leases.
  bool wait_for_heartbeat_with(std::size_t leases);

  std::map<std::uint32_t, v1::CompleteRequest> results();
  std::vector<v1::FailRequest> failures();
  int registrations();
  int granting_leases();    // calls of Lease that brought units
  int early_leases();       // calls of Lease before the first heartbeat of a registration, but the first, was
                            // answered
  std::size_t completes();  // calls, refused ones included
  std::vector<std::uint64_t> download_offsets();

 private:
  class Work;
  class Blobs;
  struct Server;
  struct Blob {
    std::string bytes;
    int corrupt_downloads = 0;
    std::size_t break_after = 0;
  };
  // With the mutex held.
  bool misreads();
  void grant(const v1::LeaseRequest& request, v1::LeaseResponse& response);
  void hear(const v1::HeartbeatRequest& request, const std::set<std::uint32_t>& revoked,
            v1::HeartbeatResponse& response);
  template <class Condition>
  bool wait_for(Condition condition);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Blob> blobs_;
  std::map<std::string, v1::JobSpec> specs_;
  std::deque<v1::Lease> offered_;
  std::size_t leased_ = 0;
  int granting_leases_ = 0;
  std::size_t leases_in_heartbeat_ = 0;
  std::map<std::uint32_t, v1::CompleteRequest> results_;
  std::vector<v1::FailRequest> failures_;
  std::set<std::string> workers_, introduced_;
  std::chrono::milliseconds introduction_{0};
  int early_leases_ = 0;
  std::string refusal_;
  int registrations_ = 0;
  int completes_to_fail_ = 0;
  int calls_to_misread_ = 0;
  grpc::StatusCode failure_code_ = grpc::StatusCode::UNAVAILABLE;
  std::size_t completes_ = 0;
  std::chrono::milliseconds heartbeat_interval_{50};
  std::set<std::uint32_t> revoked_, revoked_with_result_;
  bool drain_ = false;
  bool generous_ = false;
  bool deregistered_ = false;
  bool closing_ = false;
  std::vector<std::uint64_t> download_offsets_;
  std::unique_ptr<Server> server_;
};

}  // namespace tessera::agent
