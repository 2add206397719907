// Calls of workers over a network that loses, delays, repeats and refuses them.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "agent/link/coordinator_link.h"
#include "base/clock.h"
#include "scenario/whole_farm/chance.h"
#include "scenario/whole_farm/mortal_coordinator.h"

namespace tessera::test {

struct Network {
  base::Clock& clock;
  Chance& chance;
  MortalCoordinator& coordinator;

  bool rough = true;  // else nothing is lost, and little delayed
  // Probabilities of what happens to a call.
  double lost = 0, answer_lost = 0, late = 0, twice = 0, refused = 0, spoilt = 0;
  std::chrono::milliseconds longest_delay{5};

  std::uint64_t mishaps = 0;
  std::vector<base::Thread> late_calls = {};
};

/// The link of one machine.
class RoughLink final : public agent::CoordinatorLink {
 public:
  /// Once `*cut` is set, nothing comes or goes. The network must outlive the link.
  RoughLink(Network& network, std::shared_ptr<const bool> cut)
      : CoordinatorLink("the coordinator"), network_(network), cut_(std::move(cut)) {}

  absl::StatusOr<v1::RegisterResponse> register_worker(const v1::RegisterRequest& request,
                                                       std::stop_token stop) override;
  absl::StatusOr<v1::LeaseResponse> lease(const v1::LeaseRequest& request, std::stop_token stop) override;
  absl::StatusOr<v1::HeartbeatResponse> heartbeat(const v1::HeartbeatRequest& request,
                                                  std::stop_token stop) override;
  absl::StatusOr<v1::CompleteResponse> complete(const v1::CompleteRequest& request,
                                                std::stop_token stop) override;
  absl::Status fail(const v1::FailRequest& request, std::stop_token stop) override;
  absl::Status deregister(const v1::DeregisterRequest& request) override;
  absl::Status download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop) override;
  absl::Status upload(const UnitBlob& blob, std::stop_token stop) override;
  bool wait(net::Backoff& backoff, std::stop_token stop) override;

 private:
  enum class Fate { kArrives, kLost, kAnswerLost, kLate, kTwice, kRefused };
  Fate draw_fate();
  std::chrono::milliseconds draw_delay();
  /// `call` is given a link within the process. `owns_request`: it may be called later on, and twice.
  template <class Call>
  auto deliver(std::stop_token stop, bool owns_request, Call call);

  Network& network_;
  const std::shared_ptr<const bool> cut_;
};

}  // namespace tessera::test
