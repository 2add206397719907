// How long to go on trying when the coordinator does not answer.
#pragma once

#include <google/protobuf/message.h>

#include <chrono>
#include <functional>
#include <stop_token>
#include <string>
#include <type_traits>

#include "absl/status/statusor.h"
#include "base/printable.h"
#include "net/backoff.h"
#include "wire/printable_message.h"

namespace tessera::client {

/// The state of the connection as a user sees it. Not thread-safe.
class Contact {
 public:
  using Clock = std::chrono::steady_clock;
  using Notice = std::function<void(const std::string&)>;
  /// Sleeps for the time given, or until another attempt is worth while; false when a stop was requested.
  using Wait = std::function<bool(std::chrono::milliseconds, std::stop_token)>;

  /// Errors that may pass are waited out for `first_patience` while the coordinator was never reached, later
  /// for `later_patience`. `notice` is told once a break that contact is lost, and that it is back.
  Contact(std::string address, std::chrono::milliseconds first_patience,
          std::chrono::milliseconds later_patience, Notice notice, Wait wait = net::interruptible_sleep);

  /// Repeats `call`, which returns a StatusOr, until it succeeds, fails for good, or patience is at an end.
  /// The text of a message, which others have written, is safe to be shown.
  template <class Call>
  auto retried(std::stop_token stop, Call call) -> decltype(call()) {
    while (true) {
      auto response = call();
      if (response.ok()) {
        succeeded();
        using Response = typename decltype(call())::value_type;
        if constexpr (std::is_base_of_v<google::protobuf::Message, Response>) wire::make_printable(*response);
        return response;
      }
      if (absl::Status given_up = failed(response.status(), stop); !given_up.ok()) return given_up;
    }
  }

  /// The coordinator answered.
  void succeeded();

  /// A call failed. OK after a pause, when it is worth another attempt; else the error to give up with.
  absl::Status failed(const absl::Status& status, std::stop_token stop);

  const std::string& address() const { return address_; }

 private:
  const std::string address_;
  const std::chrono::milliseconds first_patience_;
  const std::chrono::milliseconds later_patience_;
  const Notice notice_;
  const Wait wait_;
  net::Backoff backoff_{std::chrono::milliseconds{100}, std::chrono::milliseconds{1000}};
  bool reached_ = false;
  bool broken_ = false;
  Clock::time_point broken_since_;
};

}  // namespace tessera::client
