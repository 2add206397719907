// The streams that callers have open, and what ends them from this side.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <list>
#include <mutex>
#include <string>

#include "base/clock.h"
#include "service/farm/accounts.h"
#include "service/rpc/access.h"
#include "telemetry/line_limit.h"

namespace tessera::server {

/// Ends streams whose other end takes, or sends, nothing: what they hold (a message, a part of a blob and its
/// claim) would be held for as long as somebody likes. They may be begun again where they were. Thread-safe;
/// must outlive all streams.
class OpenStreams {
 public:
  /// `patience`: with one message, which has at most a few MB.
  OpenStreams(std::chrono::milliseconds patience, std::shared_ptr<Accounts> accounts,
              const base::Clock& clock)
      : patience_(patience), accounts_(std::move(accounts)), clock_(clock) {}

  /// One of them, from before its first message until gRPC is done with it: the context must live as long.
  class Stream {
   public:
    /// `kind`: "download" ...
    Stream(OpenStreams& all, grpc::CallbackServerContext* context, const char* kind);
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    /// ResourceExhausted where the caller has as many as one may have: the stream is to end with that.
    absl::Status admitted() const { return account_.status(); }

    /// A message is on its way, in either direction; one at a time.
    void begin_message() { since_ = all_.clock_.now().time_since_epoch(); }
    /// It went through, or never will.
    void end_message() { since_ = kNone; }

   private:
    friend OpenStreams;
    static constexpr base::Clock::TimePoint::duration kNone{0};

    OpenStreams& all_;
    grpc::CallbackServerContext* const context_;
    const char* const kind_;
    const Caller caller_;
    const absl::StatusOr<std::shared_ptr<const Accounts::Hold>> account_;
    std::atomic<base::Clock::TimePoint::duration> since_{kNone};
    std::list<Stream*>::iterator place_;
  };

  /// Cuts off every stream whose message has been on its way for longer than its patience. To be called every
  /// second or so, or more often.
  void cut_stalled();
  /// Cuts off the streams of everybody who calls by this name in this role.
  void cut_off(Role role, const std::string& user);
  /// How many stalled, so far.
  std::uint64_t cut_count() const { return cut_; }

 private:
  const base::Clock::TimePoint::duration patience_;
  const std::shared_ptr<Accounts> accounts_;
  const base::Clock& clock_;
  std::mutex mutex_;
  std::list<Stream*> streams_;
  base::Clock::TimePoint next_look_{};
  std::atomic<std::uint64_t> cut_ = 0;
  telemetry::LineLimit lines_;
};

}  // namespace tessera::server
