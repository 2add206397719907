// Results of units, and failures.
#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/printable.h"
#include "scheduler/spot.h"
#include "service/farm/farm.h"
#include "service/farm/worker_calls.h"
#include "service/job/result_check.h"
#include "telemetry/log.h"
#include "wire/limits.h"
#include "wire/unit_counts.h"

namespace tessera::server {
namespace {

// Results that wait for the disk; more are sent back to be tried again.
constexpr std::uint64_t kMaxWaitingBytes = std::uint64_t{512} << 20;
// After so many results of a job, their cost is journaled as a sum: a restart adds up the rest only.
constexpr std::uint64_t kResultsBetweenStats = 4096;

/// A line about what a worker did with a unit.
void log_lease(spdlog::level::level_enum level, const std::string& worker, const v1::LeaseToken& token,
               absl::string_view text) {
  const std::string run = token.ranges() > 1 ? absl::StrCat("x", token.ranges()) : "";
  telemetry::log(
      level,
      {.job = token.job_id(), .unit = token.unit_index(), .attempt = token.attempt(), .worker = worker},
      "worker {}, unit {}{} of job {}: {}", worker, token.unit_index(), run, token.job_id(),
      std::string(text));
}

std::string shortened(std::string_view text) {
  return std::string(base::beginning_of(text, wire::kMaxTextBytes));
}

/// The last lines, of as many bytes together as a text may have.
std::vector<std::string> last_lines(const google::protobuf::RepeatedPtrField<std::string>& lines) {
  std::vector<std::string> kept;
  std::size_t left = wire::kMaxTextBytes;
  for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
    if (!kept.empty() && line->size() > left) break;
    kept.push_back(shortened(*line));
    left -= std::min(left, kept.back().size() + 1);  // an empty line is not free, either
  }
  std::ranges::reverse(kept);
  return kept;
}

}  // namespace

void Farm::complete(const v1::CompleteRequest& request, const Origin& origin,
                    Done<v1::CompleteResponse> done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  if (commits_.waiting_bytes() > kMaxWaitingBytes) {
    return done(absl::ResourceExhaustedError("the coordinator's disk is behind; try again in a second"));
  }
  const v1::LeaseToken& token = request.token();
  std::shared_ptr<const JobShape> shape;
  {
    const std::lock_guard lock(mutex_);
    if (absl::Status status = check_worker(request.worker_id(), origin); !status.ok())
      return done(std::move(status));
    const absl::StatusOr<JobEntry*> entry = find_job(token.job_id());
    if (!entry.ok()) return done(entry.status());
    if (absl::Status status = check_granted(request.worker_id(), token); !status.ok()) {
      metrics_.refused();
      log_lease(spdlog::level::warn, scheduler_.name_of(request.worker_id()), token, status.message());
      return done(std::move(status));
    }
    if ((*entry)->past) {
      // All of its results are there; that this is one of them is all that can be said without reading them.
      if ((*entry)->past->state == v1::DONE) return done(v1::CompleteResponse());
      return done(
          absl::FailedPreconditionError(absl::StrCat("job ", token.job_id(), " was cancelled or failed")));
    }
    shape = (*entry)->shape;
  }
  const std::optional<UnitRun> units = shape->plan->run(token.unit_index(), std::max(token.ranges(), 1u));
  if (!units) {
    return done(
        absl::InvalidArgumentError(absl::StrCat("job ", token.job_id(), " has no unit ", token.unit_index(),
                                                " of ", std::max(token.ranges(), 1u), " ranges")));
  }
  const absl::StatusOr<Fingerprints> checked = check_payload(request, *shape, *units);
  if (!checked.ok()) {
    metrics_.refused();
    const std::lock_guard lock(mutex_);
    log_lease(spdlog::level::warn, scheduler_.name_of(request.worker_id()), token,
              checked.status().message());
    return done(checked.status());
  }
  if (!shape->plan->is_of_picture(units->first)) {
    if (absl::Status status = check_made(checked->digest, shape->plan->unit(*units), shape->spec);
        !status.ok()) {
      if (absl::IsInvalidArgument(status)) refuse_blob(request, status);
      return done(std::move(status));
    }
  }
  accept_result(request, *checked, std::move(done));
}

absl::Status Farm::check_made(const std::string& digest, const v1::WorkUnit& unit, const v1::JobSpec& spec) {
  const std::lock_guard one_at_a_time(checking_);
  return check_made_blob(digest, unit, spec, blobs_);
}

/// Bytes that have their digest came as they were made: the worker has failed, and need not try again.
void Farm::refuse_blob(const v1::CompleteRequest& request, const absl::Status& why) {
  metrics_.refused();
  metrics_.failed();
  std::unique_lock lock(mutex_);
  if (const auto known = registrations_by_worker_.find(request.worker_id());
      known != registrations_by_worker_.end())
    ++known->second.failures;
  log_lease(spdlog::level::err, scheduler_.name_of(request.worker_id()), request.token(), why.message());
  static_cast<void>(scheduler_.fail(request.worker_id(), request.token(),
                                    {.message = shortened({why.message().data(), why.message().size()})},
                                    now()));
  commit({}, {}, /*wait=*/false, [](const absl::Status&) {});
  lock.unlock();
  dispatcher_.notify_work();
}

absl::StatusOr<Farm::Fingerprints> Farm::check_payload(const v1::CompleteRequest& request,
                                                       const JobShape& shape, const UnitRun& units) const {
  const auto whole = [](absl::StatusOr<std::string> digest) -> absl::StatusOr<Fingerprints> {
    if (!digest.ok()) return digest.status();
    return Fingerprints{.digest = *std::move(digest)};
  };
  const v1::LeaseToken& token = request.token();
  if (!shape.plan->is_of_picture(units.first))
    return whole(check_blob_result(request.payload(), units.first, blobs_));
  v1::WorkUnit unit = shape.plan->unit(units);
  const bool in_tiles = unit.has_tile();
  if (token.spot() != 0) {
    v1::PixelRect& pixels = *unit.mutable_tile()->mutable_pixels();
    if (!in_tiles || token.spot() > spots_in(pixels))
      return absl::InvalidArgumentError(absl::StrCat("unit ", units.first, " has no spot ", token.spot()));
    pixels = spot_pixels(pixels, token.spot());
    return whole(check_result(request.payload(), unit, shape.spec, shape.channels));
  }
  const v1::PixelRect pixels = unit.tile().pixels();
  const std::uint32_t number = in_tiles ? choose_spot(spot_key_, token, pixels) : 0;
  if (number == 0) return whole(check_result(request.payload(), unit, shape.spec, shape.channels));
  absl::StatusOr<CheckedResult> result =
      check_result_and_part(request.payload(), unit, shape.spec, shape.channels, spot_pixels(pixels, number));
  if (!result.ok()) return result.status();
  const bool scatters = shape.spec.view().reconstruction() == v1::RECONSTRUCTION_SCATTER;
  return Fingerprints{.digest = std::move(result->digest),
                      .spot = {.number = number,
                               .fingerprint = fingerprint_of(result->part),
                               .share = spot_share(pixels, scatters)}};
}

void Farm::accept_result(const v1::CompleteRequest& request, const Fingerprints& result,
                         Done<v1::CompleteResponse> done) {
  const std::string& digest = result.digest;
  const v1::LeaseToken& token = request.token();
  v1::UnitStats stats = bounded(request.stats());
  const Served served(metrics_, FarmMetrics::Call::kComplete);
  std::unique_lock lock(mutex_);
  const absl::StatusOr<CompleteDecision> decision =
      scheduler_.complete(request.worker_id(), token,
                          {.fingerprint = fingerprint_of(digest),
                           .cost = time_of(stats),
                           .work = wire::counts_of(stats).rays(),
                           .spot = result.spot},
                          now());
  if (!decision.ok()) {
    metrics_.refused();
    // A result that is refused may still decide who is at fault.
    commit({}, {}, /*wait=*/false, [](const absl::Status&) {});
    if (absl::IsAlreadyExists(decision.status())) {
      log_lease(spdlog::level::err, scheduler_.name_of(request.worker_id()), token,
                decision.status().message());
    }
    return done(decision.status());
  }
  // The first one may still be on its way to the disk: both are answered when it is there.
  if (decision->duplicate) {
    metrics_.repeated();
    return commit({}, {}, /*wait=*/true, [done = std::move(done)](const absl::Status& status) {
      status.ok() ? done(v1::CompleteResponse()) : done(status);
    });
  }
  JobEntry& entry = *jobs_.find(token.job_id());
  // Nothing takes longer than its lease lasted, nor than its job is old where that is not known.
  const std::chrono::milliseconds lasted =
      decision->lasted.value_or(std::chrono::milliseconds(unix_now() - entry.submitted_unix_ms));
  stats = bounded_by(std::move(stats), lasted, decision->threads);
  metrics_.completed(time_of(stats), request.payload().size());

  const std::string host = scheduler_.host_of(request.worker_id());
  const CoveredUnits units{.first = token.unit_index(), .ranges = std::max(token.ranges(), 1u)};
  add_result(entry, units, host, stats);
  if (!entry.shape->plan->is_of_picture(units.first)) {
    entry.phase_blobs.note(units.first, digest, decision->sequence);
    uploads_.forget(digest);
    lease_uploads_.claim(digest);
  }
  entry.rate.note(entry.units, now());
  std::vector<JournalEntry> entries;
  entries.push_back(UnitDone{.job = entry.id,
                             .sequence = decision->sequence,
                             .units = units,
                             .digest = digest,
                             .payload = request.payload(),
                             .stats = stats.SerializeAsString(),
                             .host = host});
  if (decision->sequence % kResultsBetweenStats == 0) entries.push_back(stats_of(entry));
  entry.result_bytes += request.payload().size();
  if (spdlog::should_log(spdlog::level::debug)) {
    log_lease(spdlog::level::debug, scheduler_.name_of(request.worker_id()), token, "result accepted");
  }
  const bool news_for_others = scheduler_.frees_workers() || decision->opened;
  v1::CompleteResponse response;
  if (request.has_beat()) {
    if (auto beaten = beat(request.worker_id(), request.beat()); beaten.ok())
      *response.mutable_beat() = *std::move(beaten);
  }
  if (request.has_more() && names_few(request.more())) {
    if (auto more = grant(request.worker_id(), request.more()); more.ok())
      *response.mutable_more() = *std::move(more);
  }
  commit(std::move(entries), {{.job = entry.id, .results = decision->sequence, .end = false}}, /*wait=*/true,
         [response = std::move(response), done = std::move(done)](const absl::Status& status) {
           status.ok() ? done(response) : done(status);
         });
  lock.unlock();
  dispatcher_.notify_worker(request.worker_id());
  if (news_for_others) dispatcher_.notify_work();
}

void Farm::fail(const v1::FailRequest& request, const Origin& origin, DoneEmpty done) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  const v1::LeaseToken& token = request.token();
  const Served served(metrics_, FarmMetrics::Call::kFail);
  std::unique_lock lock(mutex_);
  if (absl::Status status = check_worker(request.worker_id(), origin); !status.ok())
    return done(std::move(status));
  const auto open_job = [&]() -> absl::StatusOr<JobEntry*> {
    absl::StatusOr<JobEntry*> entry = find_job(token.job_id());
    if (entry.ok() && (*entry)->past)
      return absl::FailedPreconditionError(absl::StrCat("job ", token.job_id(), " is over"));
    return entry;
  };
  absl::StatusOr<JobEntry*> entry = find_job(token.job_id());
  if (!entry.ok()) return done(entry.status());
  if (absl::Status status = check_granted(request.worker_id(), token); !status.ok())
    return done(std::move(status));
  if (entry = open_job(); !entry.ok()) return done(entry.status());
  // A unit that reads what is gone is not to blame: the source is made anew, and the lease is over.
  const PhasePlan& phases = (*entry)->shape->plan->phases();
  if (std::vector<PhaseBlobs::Made> inputs = (*entry)->phase_blobs.inputs(phases, token.unit_index());
      !inputs.empty()) {
    lock.unlock();
    inputs = lost(std::move(inputs));
    lock.lock();
    if (entry = open_job(); !entry.ok()) return done(entry.status());
    for (const PhaseBlobs::Made& made : inputs) {
      static_cast<void>(scheduler_.revoke_result(token.job_id(), made.unit, made.sequence,
                                                 absl::StrCat("its blob ", made.digest, " is gone")));
    }
  }
  const FailureReport report{.message = shortened(request.message()),
                             .scene_fault = request.scene_fault(),
                             .inputs_fault = request.inputs_fault(),
                             .log = last_lines(request.log())};
  const absl::Status failed = scheduler_.fail(request.worker_id(), token, report, now());
  if (!failed.ok()) return done(failed);
  metrics_.failed();
  if (const auto known = registrations_by_worker_.find(request.worker_id());
      known != registrations_by_worker_.end())
    ++known->second.failures;
  log_lease(spdlog::level::warn, scheduler_.name_of(request.worker_id()), token,
            absl::StrCat("failed: ", report.message));
  commit({}, {}, /*wait=*/true, std::move(done));
  lock.unlock();
  dispatcher_.notify_work();
}

}  // namespace tessera::server
