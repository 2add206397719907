#include "service/rpc/open_streams.h"

#include "telemetry/log.h"

namespace tessera::server {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{250};

}  // namespace

OpenStreams::Stream::Stream(OpenStreams& all, grpc::CallbackServerContext* context, const char* kind)
    : all_(all),
      context_(context),
      kind_(kind),
      caller_(caller_of(context->auth_context().get())),
      account_(all.accounts_->take(holder_of(caller_.user, context->peer()), {.streams = 1})) {
  const std::lock_guard lock(all_.mutex_);
  place_ = all_.streams_.insert(all_.streams_.end(), this);
}

OpenStreams::Stream::~Stream() {
  const std::lock_guard lock(all_.mutex_);
  all_.streams_.erase(place_);
}

void OpenStreams::cut_stalled() {
  const base::Clock::TimePoint now = clock_.now();
  // gRPC calls a reactor's functions from threads of its own, not from within TryCancel: none of them waits
  // for this.
  const std::lock_guard lock(mutex_);
  if (now < next_look_) return;
  next_look_ = now + kBetweenLooks;
  for (Stream* const stream : streams_) {
    base::Clock::TimePoint::duration since = stream->since_;
    if (since == Stream::kNone || now.time_since_epoch() - since <= patience_) continue;
    if (!stream->since_.compare_exchange_strong(since, Stream::kNone)) continue;  // it went through just now
    stream->context_->TryCancel();
    ++cut_;
    const auto [write, left_out] = lines_.count();
    if (!write) continue;
    const std::string peer = stream->context_->peer();
    telemetry::log(
        spdlog::level::warn, {.user = stream->caller_.user, .peer = peer},
        "cut off: the other end of a stream ({}) let a message wait for {:.1f} s ({} such lines left "
        "out before)",
        stream->kind_, std::chrono::duration<double>(now.time_since_epoch() - since).count(), left_out);
  }
}

void OpenStreams::cut_off(Role role, const std::string& user) {
  const std::lock_guard lock(mutex_);
  for (Stream* const stream : streams_) {
    if (stream->caller_.role == role && stream->caller_.user == user) stream->context_->TryCancel();
  }
}

}  // namespace tessera::server
