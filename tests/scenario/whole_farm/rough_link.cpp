#include "scenario/whole_farm/rough_link.h"

#include <utility>

#include "local/local_link.h"

namespace tessera::test {
namespace {

using std::chrono::milliseconds;

// Deadlines of calls over gRPC are of that order.
constexpr milliseconds kShortestPatience{100}, kLongestPatience{15'000};

/// Makes the call where the coordinator is, if there is one.
template <class Call>
auto call_coordinator(MortalCoordinator& coordinator, const Call& call, std::stop_token stop)
    -> decltype(call(std::declval<agent::CoordinatorLink&>(), stop)) {
  const MortalCoordinator::Visit visit = coordinator.visit();
  if (!visit) return absl::UnavailableError("nobody listens there");
  client::LocalLink link(visit.farm(), coordinator.blobs());
  return call(link, std::move(stop));
}

}  // namespace

RoughLink::Fate RoughLink::draw_fate() {
  Network& net = network_;
  if (!net.rough) return Fate::kArrives;
  const std::pair<double, Fate> fates[] = {{net.lost, Fate::kLost},
                                           {net.answer_lost, Fate::kAnswerLost},
                                           {net.late, Fate::kLate},
                                           {net.twice, Fate::kTwice},
                                           {net.refused, Fate::kRefused}};
  for (const auto& [probability, fate] : fates) {
    if (!net.chance.of(probability)) continue;
    ++net.mishaps;
    return fate;
  }
  return Fate::kArrives;
}

milliseconds RoughLink::draw_delay() {
  // Most calls are quick.
  if (!network_.rough || network_.chance.of(0.8)) return network_.chance.between({}, milliseconds{2});
  return network_.chance.between({}, network_.longest_delay);
}

template <class Call>
auto RoughLink::deliver(std::stop_token stop, bool owns_request, Call call) {
  using Answer = decltype(call(std::declval<agent::CoordinatorLink&>(), stop));
  Network& net = network_;
  if (!base::pause(net.clock, draw_delay(), stop)) return Answer(absl::CancelledError("given up"));
  if (*cut_) return Answer(absl::UnavailableError("the cable is cut"));
  const Fate fate = draw_fate();
  if (fate == Fate::kRefused) return Answer(absl::ResourceExhaustedError("too much to do"));
  if (fate == Fate::kLate && owns_request) {
    const milliseconds delay = net.chance.between({}, 2 * kLongestPatience);
    net.late_calls.push_back(net.clock.start("late call", [&net, delay, call](std::stop_token) {
      base::pause(net.clock, delay, {});
      static_cast<void>(call_coordinator(net.coordinator, call, {}));
    }));
  }
  const bool arrives = fate == Fate::kArrives || fate == Fate::kTwice || fate == Fate::kAnswerLost;
  Answer answer = absl::DeadlineExceededError("no answer");
  if (arrives) answer = call_coordinator(net.coordinator, call, stop);
  if (fate == Fate::kTwice && owns_request) answer = call_coordinator(net.coordinator, call, stop);
  if (!arrives || fate == Fate::kAnswerLost) {
    base::pause(net.clock, net.chance.between(kShortestPatience, kLongestPatience), stop);
    return Answer(absl::DeadlineExceededError("no answer"));
  }
  base::pause(net.clock, draw_delay(), stop);
  if (*cut_) return Answer(absl::UnavailableError("the cable is cut"));
  return answer;
}

absl::StatusOr<v1::RegisterResponse> RoughLink::register_worker(const v1::RegisterRequest& request,
                                                                std::stop_token stop) {
  return deliver(std::move(stop), /*owns_request=*/true,
                 [request](CoordinatorLink& link, std::stop_token until) {
                   return link.register_worker(request, std::move(until));
                 });
}

absl::StatusOr<v1::LeaseResponse> RoughLink::lease(const v1::LeaseRequest& request, std::stop_token stop) {
  return deliver(std::move(stop), /*owns_request=*/true,
                 [request](CoordinatorLink& link, std::stop_token until) {
                   return link.lease(request, std::move(until));
                 });
}

absl::StatusOr<v1::HeartbeatResponse> RoughLink::heartbeat(const v1::HeartbeatRequest& request,
                                                           std::stop_token stop) {
  return deliver(std::move(stop), /*owns_request=*/true,
                 [request](CoordinatorLink& link, std::stop_token until) {
                   return link.heartbeat(request, std::move(until));
                 });
}

absl::StatusOr<v1::CompleteResponse> RoughLink::complete(const v1::CompleteRequest& request,
                                                         std::stop_token stop) {
  return deliver(std::move(stop), /*owns_request=*/true,
                 [request](CoordinatorLink& link, std::stop_token until) {
                   return link.complete(request, std::move(until));
                 });
}

absl::Status RoughLink::fail(const v1::FailRequest& request, std::stop_token stop) {
  return deliver(std::move(stop), /*owns_request=*/true,
                 [request](CoordinatorLink& link, std::stop_token until) {
                   return link.fail(request, std::move(until));
                 });
}

absl::Status RoughLink::deregister(const v1::DeregisterRequest& request) {
  return deliver({}, /*owns_request=*/true,
                 [request](CoordinatorLink& link, std::stop_token) { return link.deregister(request); });
}

absl::Status RoughLink::download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop) {
  const bool spoilt = network_.rough && network_.chance.of(network_.spoilt);
  network_.mishaps += spoilt;
  const ChunkSink spoiling_sink = [&](std::string_view chunk) {
    std::string bytes(chunk);
    if (spoilt && !bytes.empty()) bytes.back() ^= 1;
    return sink(bytes);
  };
  return deliver(std::move(stop), /*owns_request=*/false, [&](CoordinatorLink& link, std::stop_token until) {
    return link.download(wanted, spoiling_sink, std::move(until));
  });
}

absl::Status RoughLink::upload(const UnitBlob& blob, std::stop_token stop) {
  return deliver(std::move(stop), /*owns_request=*/false, [&](CoordinatorLink& link, std::stop_token until) {
    return link.upload(blob, std::move(until));
  });
}

bool RoughLink::wait(net::Backoff&, std::stop_token stop) {
  // The back-off's own delays are random each time.
  return base::pause(network_.clock, network_.chance.between(milliseconds{50}, milliseconds{2000}), stop);
}

}  // namespace tessera::test
