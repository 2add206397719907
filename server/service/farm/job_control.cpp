#include "service/farm/job_control.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "service/farm/farm_core.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_retention.h"
#include "service/farm/user_shares.h"

namespace tessera::server {

JobControl::JobControl(FarmCore& core, const UserShares& shares, JobRetention& retention, FarmViews& views)
    : core_(core), shares_(shares), retention_(retention), views_(views) {}

void JobControl::answer_with_status(const absl::Status& changed, const std::string& id,
                                    Done<v1::JobStatus> done) {
  if (!changed.ok()) return done(changed);
  core_.commit({}, [this, id, done = std::move(done)](const absl::Status& status) {
    if (!status.ok()) return done(status);
    absl::StatusOr<v1::GetJobResponse> job = views_.get_job(id);
    job.ok() ? done(std::move(*job->mutable_status())) : done(job.status());
  });
  core_.dispatcher().notify_work();
}

void JobControl::cancel(const std::string& id, Done<v1::JobStatus> done) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(core_.mutex());
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok()) return done(entry.status());
  answer_with_status((*entry)->past ? absl::OkStatus() : core_.scheduler().cancel_job(id).status(), id,
                     std::move(done));
}

void JobControl::delete_job(const std::string& id, DoneEmpty done) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(core_.mutex());
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok()) return done(entry.status());
  if (!(*entry)->durable_end) {
    return done(absl::FailedPreconditionError(absl::StrCat("job ", id, " is not over: cancel it first")));
  }
  core_.tell(news::JobDeleted{**entry, /*on_request=*/true});
  retention_.forget(id, std::move(done));
}

void JobControl::retry(const std::string& id, Done<v1::JobStatus> done, const Caller& by) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(core_.mutex());
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok()) return done(entry.status());
  if ((*entry)->past) {
    const bool is_done = (*entry)->past->state == v1::DONE;
    const absl::Status over =
        absl::FailedPreconditionError(absl::StrCat("job ", id, " is over and not incomplete"));
    return answer_with_status(is_done ? absl::OkStatus() : over, id, std::move(done));
  }
  absl::Status status = absl::OkStatus();
  if (core_.scheduler().job(id)->state == v1::INCOMPLETE) status = shares_.check_reopening(by, **entry);
  if (status.ok()) status = core_.scheduler().retry_job(id);
  answer_with_status(status, id, std::move(done));
}

void JobControl::adjust(const v1::AdjustJobRequest& request, Done<v1::JobStatus> done, const Caller& by) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  const std::lock_guard lock(core_.mutex());
  const std::string& id = request.job_id();
  const absl::StatusOr<JobEntry*> entry = core_.find_job(id);
  if (!entry.ok()) return done(entry.status());
  absl::Status status =
      (*entry)->past ? absl::FailedPreconditionError(absl::StrCat("job ", id, " is over")) : absl::OkStatus();
  if (status.ok() && request.has_priority()) status = shares_.check_priority(by, request.priority());
  if (status.ok() && request.has_paused()) status = core_.scheduler().pause_job(id, request.paused());
  if (status.ok() && request.has_priority()) status = core_.scheduler().set_priority(id, request.priority());
  answer_with_status(status, id, std::move(done));
}

void JobControl::note_fetched(const std::string& id) {
  const std::lock_guard lock(core_.mutex());
  JobEntry* const entry = core_.jobs().find(id);
  if (entry == nullptr || entry->fetched || !entry->durable_end) return;
  entry->fetched = true;
  core_.commit({.entries = {JobFetched{.id = id}}}, [](const absl::Status&) {});
}

}  // namespace tessera::server
