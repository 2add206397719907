#include "net/channel.h"

#include <grpc/grpc.h>
#include <grpcpp/channel.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <algorithm>

#include "base/address.h"
#include "net/backoff.h"
#include "net/tls.h"
#include "wire/limits.h"

namespace tessera::net {
namespace {

// How late a request to stop may be noticed.
constexpr std::chrono::milliseconds kLongestWait{50};

/// Once begun, gRPC runs until the process ends. It would shut down with the last channel, and whoever makes
/// the next one would wait up to ten seconds for that: the deadline of a thread that has helped with large
/// messages (tcp_posix.cc of gRPC 1.51, run_poller).
void keep_grpc_running() { [[maybe_unused]] static const bool kept = (grpc_init(), true); }

}  // namespace

grpc::ChannelArguments channel_arguments() {
  keep_grpc_running();
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(static_cast<int>(wire::kMaxMessageBytes));
  arguments.SetMaxSendMessageSize(static_cast<int>(wire::kMaxMessageBytes));
  // A peer whose machine is gone is noticed within 15 s, long polls included.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  // gRPC means by it the time that a connection has to be made, handshakes included. They take long over
  // slow links, on busy machines, and when ten thousand workers come back at once; packets that were lost on
  // the way are sent again 1, 3 and 7 s later.
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 10'000);
  // Jitter makes it a fifth longer.
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 800);
  return arguments;
}

absl::StatusOr<std::shared_ptr<grpc::Channel>> make_channel(std::string_view address,
                                                            const ChannelOptions& options) {
  const absl::StatusOr<base::HostPort> host_port = base::parse_host_port(address);
  if (!host_port.ok()) return host_port.status();
  if (!options.certificates.empty()) {
    if (absl::Status status = check_certificates(options.certificates); !status.ok()) return status;
    return grpc::CreateCustomChannel(host_port->to_string(), channel_credentials(options.certificates),
                                     channel_arguments());
  }
  if (absl::Status status = base::check_unencrypted_allowed(*host_port, options.allow_insecure); !status.ok())
    return status;
  return grpc::CreateCustomChannel(host_port->to_string(), grpc::InsecureChannelCredentials(),
                                   channel_arguments());
}

bool wait_for_connection(grpc::Channel& channel, std::chrono::milliseconds delay, std::stop_token stop) {
  grpc_connectivity_state state = channel.GetState(/*try_to_connect=*/true);
  // Channels within one process are not made anew, and say that they are shut down.
  if (state == GRPC_CHANNEL_READY || state == GRPC_CHANNEL_SHUTDOWN) return interruptible_sleep(delay, stop);
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + delay;
  while (state != GRPC_CHANNEL_READY && !stop.stop_requested()) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) break;
    const auto patience = gpr_time_from_millis(std::min(left, kLongestWait).count(), GPR_TIMESPAN);
    channel.WaitForStateChange(state, gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC), patience));
    state = channel.GetState(/*try_to_connect=*/true);
  }
  return !stop.stop_requested();
}

}  // namespace tessera::net
