#include "service/rpc/watch_reactor.h"

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>

#include "net/status.h"
#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/rpc/open_streams.h"

namespace tessera::server {
namespace {

constexpr std::chrono::milliseconds kStatusInterval{800};  // below the second that watchers are promised

class WatchReactor final : public grpc::ServerWriteReactor<v1::WatchJobResponse> {
 public:
  WatchReactor(Farm& farm, OpenStreams& streams, grpc::CallbackServerContext* context,
               const v1::WatchJobRequest& request)
      : farm_(farm),
        stream_(std::in_place, streams, context, "watch"),
        job_(request.job_id()),
        status_only_(request.status_only()),
        after_(request.after()) {}

  void start() {
    self_.reset(this);
    if (const absl::Status status = stream_->admitted(); !status.ok()) {
      const std::shared_ptr<WatchReactor> self = self_;
      const std::lock_guard lock(mutex_);
      finish(net::to_grpc(status));
      return;
    }
    farm_.subscribe([self = self_] { return self->wake(); });
    wake();
  }

  void OnWriteDone(bool ok) override {
    const std::shared_ptr<WatchReactor> self = self_;  // what follows may end the call, and OnDone with it
    bool fetched = false;
    {
      const std::lock_guard lock(mutex_);
      stream_->end_message();
      writing_ = false;
      broken_ |= !ok;
      fetched = ok && last_message_sent_ && !status_only_;
    }
    if (fetched) farm_.jobs().note_fetched(job_);
    wake();
  }

  void OnCancel() override {
    const std::shared_ptr<WatchReactor> self = self_;
    {
      const std::lock_guard lock(mutex_);
      broken_ = true;
    }
    wake();
  }

  /// gRPC is done with the reactor; a wake that is under way may still hold it.
  void OnDone() override {
    const std::shared_ptr<WatchReactor> self = std::move(self_);
    const std::lock_guard lock(mutex_);
    stream_.reset();
  }

 private:
  /// Sends what there is to send; false when there never will be more.
  bool wake() {
    const std::lock_guard lock(mutex_);
    if (over_) return false;
    if (writing_) return true;
    if (broken_) return finish(grpc::Status::CANCELLED);
    if (last_message_sent_) return finish(grpc::Status::OK);
    if (farm_.stopping()) return finish({grpc::StatusCode::UNAVAILABLE, "the coordinator is shutting down"});

    absl::StatusOr<WatchBatch> batch = farm_.views().next_results(job_, after_, status_only_);
    if (!batch.ok()) return finish(net::to_grpc(batch.status()));
    const bool status_due = !last_message_ || farm_.clock().now() - *last_message_ >= kStatusInterval;
    if (batch->response.results().empty() && !batch->finished && !status_due) return true;
    message_ = std::move(batch->response);
    after_ = batch->last;
    last_message_sent_ = batch->finished;
    last_message_ = farm_.clock().now();
    writing_ = true;
    stream_->begin_message();
    StartWrite(&message_);
    return true;
  }

  bool finish(const grpc::Status& status) {
    over_ = true;
    Finish(status);
    return false;
  }

  Farm& farm_;
  std::optional<OpenStreams::Stream> stream_;  // until gRPC is done with it; with mutex_ held
  const std::string job_;
  const bool status_only_;

  std::mutex mutex_;
  std::uint64_t after_;
  v1::WatchJobResponse message_;
  std::optional<base::Clock::TimePoint> last_message_;
  bool writing_ = false;
  bool broken_ = false;
  bool last_message_sent_ = false;
  bool over_ = false;
  std::shared_ptr<WatchReactor> self_;
};

}  // namespace

grpc::ServerWriteReactor<v1::WatchJobResponse>* watch_job(Farm& farm, OpenStreams& streams,
                                                          grpc::CallbackServerContext* context,
                                                          const v1::WatchJobRequest& request) {
  auto* const reactor = new WatchReactor(farm, streams, context, request);
  reactor->start();
  return reactor;
}

}  // namespace tessera::server
