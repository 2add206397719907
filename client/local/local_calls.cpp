#include "local/local_calls.h"

#include <chrono>
#include <utility>

#include "base/clock.h"
#include "local/awaited.h"
#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/farm/job_submission.h"
#include "wire/printable_message.h"

namespace tessera::client {
namespace {

/// Results that come in this time are looked at together.
constexpr std::chrono::milliseconds kGathering{4};

/// Text that scenes and others have written is safe to be shown.
template <class Message>
absl::StatusOr<Message> printable(absl::StatusOr<Message> message) {
  if (message.ok()) wire::make_printable(*message);
  return message;
}

/// News of any job. The farm holds it until it is over.
class News {
 public:
  explicit News(base::Clock& clock) : clock_(clock) {}

  /// Serves as the callback of Farm::subscribe.
  bool wake() {
    bool over;
    {
      const std::lock_guard lock(mutex_);
      there_are_ = true;
      over = over_;
    }
    changed_.notify_all();
    return !over;
  }
  /// Until there are some, or `stop` is requested, or the time is up.
  void wait(const std::stop_token& stop, std::chrono::seconds longest) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, stop, clock_.now() + longest, [this] { return there_are_; });
    there_are_ = false;
  }
  void end() {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }

 private:
  base::Clock& clock_;
  std::mutex mutex_;
  base::Condition changed_{clock_};
  bool there_are_ = false, over_ = false;
};

/// Whoever stops the farm because it failed requests the stop of this thread next, and has the cause.
absl::Status wait_for_cause(base::Clock& clock, const std::stop_token& stop) {
  if (!base::pause(clock, std::chrono::seconds{15}, stop))
    return absl::CancelledError("WatchJob: it was given up");
  return absl::UnavailableError("WatchJob: the coordinator has stopped");
}

}  // namespace

absl::StatusOr<std::string> LocalCalls::submit(const v1::JobSpec& spec, const Reuse& reuse,
                                               std::stop_token stop) {
  v1::SubmitJobRequest request;
  request.set_request_id(reuse.request_id.empty() ? make_request_id() : reuse.request_id);
  *request.mutable_spec() = spec;
  request.set_continued(reuse.continued);
  request.set_fresh(reuse.fresh);
  Awaited<absl::StatusOr<std::string>> answer(farm_.clock());
  farm_.submission().submit(request, answer.done());
  return answer.wait(std::move(stop));
}

absl::StatusOr<v1::GetJobResponse> LocalCalls::job(const std::string& job_id, std::stop_token) {
  return printable(farm_.views().get_job(job_id));
}

absl::StatusOr<std::vector<v1::JobStatus>> LocalCalls::jobs(std::stop_token) {
  v1::ListJobsResponse response = farm_.views().list_jobs();
  wire::make_printable(response);
  return std::vector<v1::JobStatus>{response.jobs().begin(), response.jobs().end()};
}

absl::StatusOr<v1::JobStatus> LocalCalls::cancel(const std::string& job_id, std::stop_token stop) {
  Awaited<absl::StatusOr<v1::JobStatus>> answer(farm_.clock());
  farm_.jobs().cancel(job_id, answer.done());
  return printable(answer.wait(std::move(stop)));
}

absl::StatusOr<v1::JobStatus> LocalCalls::watch(const std::string& job_id, const WatchHandlers& handlers,
                                                std::stop_token stop) {
  const auto news = std::make_shared<News>(farm_.clock());
  farm_.subscribe([news] { return news->wake(); });
  const auto end = [](News* ended) { ended->end(); };
  const std::unique_ptr<News, decltype(end)> ends(news.get(), end);

  const bool status_only = !handlers.result;
  WatchProgress progress;
  std::uint64_t after = 0;  // counts results that are not of the picture, too
  while (!stop.stop_requested()) {
    if (farm_.stopping()) return wait_for_cause(farm_.clock(), stop);
    absl::StatusOr<server::WatchBatch> batch = farm_.views().next_results(job_id, after, status_only);
    if (!batch.ok()) return batch.status();
    const bool more = batch->last > after;
    after = batch->last;
    if (!progress.take(batch->response, handlers)) {
      if (!progress.handler_status.ok()) return progress.handler_status;
      if (std::exchange(progress.restarted, false)) after = 0;
      continue;
    }
    if (batch->finished) {
      if (!status_only) farm_.jobs().note_fetched(job_id);
      return progress.last;
    }
    // The farm has news at least every second; were one lost, the next would do.
    if (more) continue;
    news->wait(stop, std::chrono::seconds{2});
    base::pause(farm_.clock(), kGathering, stop);
  }
  return absl::CancelledError("WatchJob: it was given up");
}

}  // namespace tessera::client
