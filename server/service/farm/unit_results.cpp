#include "service/farm/unit_results.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/printable.h"
#include "scheduler/spot.h"
#include "service/farm/farm_core.h"
#include "service/farm/lease_seal.h"
#include "service/farm/user_shares.h"
#include "service/farm/worker_leases.h"
#include "service/farm/worker_registry.h"
#include "service/job/result_check.h"
#include "wire/limits.h"
#include "wire/unit_counts.h"

namespace tessera::server {
namespace {

using Reason = news::ResultRefused::Reason;

// Results that wait for the disk; more are sent back to be tried again.
constexpr std::uint64_t kMaxWaitingBytes = std::uint64_t{512} << 20;
// After so many results of a job, their cost is journaled as a sum: a restart adds up the rest only.
constexpr std::uint64_t kResultsBetweenStats = 4096;

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

CoveredUnits units_of(const v1::LeaseToken& token) {
  return {.first = token.unit_index(), .ranges = std::max(token.ranges(), 1u)};
}

}  // namespace

UnitResults::UnitResults(FarmCore& core, WorkerRegistry& workers, WorkerLeases& leases, UserShares& shares)
    : core_(core),
      workers_(workers),
      leases_(leases),
      shares_(shares),
      spot_key_(core.options().seal->derive_key("spots")) {}

// ---------------------------------------------------------------- results

void UnitResults::complete(const v1::CompleteRequest& request, const WorkerOrigin& origin,
                           Done<v1::CompleteResponse> done) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  if (core_.waiting_bytes() > kMaxWaitingBytes) {
    return done(absl::ResourceExhaustedError("the coordinator's disk is behind; try again in a second"));
  }
  const v1::LeaseToken& token = request.token();
  std::shared_ptr<const JobShape> shape;
  {
    const std::lock_guard lock(core_.mutex());
    if (absl::Status status = workers_.check(request.worker_id(), origin); !status.ok())
      return done(std::move(status));
    const absl::StatusOr<JobEntry*> entry = core_.find_job(token.job_id());
    if (!entry.ok()) return done(entry.status());
    if (absl::Status status = leases_.check_granted(request.worker_id(), token); !status.ok()) {
      core_.tell(news::ResultRefused{core_.scheduler().name_of(request.worker_id()), token,
                                     Reason::kNotGranted, status});
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
  const CoveredUnits covered = units_of(token);
  const std::optional<UnitRun> units = shape->plan->run(covered.first, covered.ranges);
  if (!units) {
    return done(absl::InvalidArgumentError(absl::StrCat("job ", token.job_id(), " has no unit ",
                                                        covered.first, " of ", covered.ranges, " ranges")));
  }
  const absl::StatusOr<Fingerprints> checked = check_payload(request, *shape, *units);
  if (!checked.ok()) {
    const std::lock_guard lock(core_.mutex());
    core_.tell(news::ResultRefused{core_.scheduler().name_of(request.worker_id()), token, Reason::kUnsound,
                                   checked.status()});
    return done(checked.status());
  }
  if (!shape->plan->is_of_picture(units->first)) {
    if (absl::Status status = check_made(checked->digest, shape->plan->unit(*units), shape->spec);
        !status.ok()) {
      if (absl::IsInvalidArgument(status)) refuse_blob(request, status);
      return done(std::move(status));
    }
  }
  accept(request, *checked, std::move(done));
}

absl::Status UnitResults::check_made(const std::string& digest, const v1::WorkUnit& unit,
                                     const v1::JobSpec& spec) {
  const std::lock_guard one_at_a_time(checking_);
  return check_made_blob(digest, unit, spec, core_.blobs());
}

void UnitResults::refuse_blob(const v1::CompleteRequest& request, const absl::Status& why) {
  {
    const std::lock_guard lock(core_.mutex());
    const std::string& worker = request.worker_id();
    workers_.note_failure(worker);
    core_.tell(
        news::ResultRefused{core_.scheduler().name_of(worker), request.token(), Reason::kMisrendered, why});
    static_cast<void>(core_.scheduler().fail(
        worker, request.token(), {.message = shortened({why.message().data(), why.message().size()})},
        core_.now()));
    core_.commit();
  }
  core_.dispatcher().notify_work();
}

absl::StatusOr<UnitResults::Fingerprints> UnitResults::check_payload(const v1::CompleteRequest& request,
                                                                     const JobShape& shape,
                                                                     const UnitRun& units) const {
  const auto whole = [](absl::StatusOr<std::string> digest) -> absl::StatusOr<Fingerprints> {
    if (!digest.ok()) return digest.status();
    return Fingerprints{.digest = *std::move(digest)};
  };
  const v1::LeaseToken& token = request.token();
  if (!shape.plan->is_of_picture(units.first))
    return whole(check_blob_result(request.payload(), units.first, core_.blobs()));
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

void UnitResults::accept(const v1::CompleteRequest& request, const Fingerprints& result,
                         Done<v1::CompleteResponse> done) {
  const v1::LeaseToken& token = request.token();
  v1::UnitStats stats = bounded(request.stats());
  const TimedCall timed(core_, news::Call::kComplete);
  std::unique_lock lock(core_.mutex());
  const absl::StatusOr<CompleteDecision> decision =
      core_.scheduler().complete(request.worker_id(), token,
                                 {.fingerprint = fingerprint_of(result.digest),
                                  .cost = time_of(stats),
                                  .work = wire::counts_of(stats).rays(),
                                  .spot = result.spot},
                                 core_.now());
  if (!decision.ok()) {
    // A result that is refused may still decide who is at fault.
    core_.commit();
    const Reason reason =
        absl::IsAlreadyExists(decision.status()) ? Reason::kContradicted : Reason::kNotWanted;
    core_.tell(news::ResultRefused{core_.scheduler().name_of(request.worker_id()), token, reason,
                                   decision.status()});
    return done(decision.status());
  }
  // The first one may still be on its way to the disk: both are answered when it is there.
  if (decision->duplicate) {
    core_.tell(news::ResultRepeated{});
    return core_.commit({}, [done = std::move(done)](const absl::Status& status) {
      status.ok() ? done(v1::CompleteResponse()) : done(status);
    });
  }
  JobEntry& entry = *core_.jobs().find(token.job_id());
  std::vector<JournalEntry> entries = add(entry, request, result.digest, std::move(stats), *decision);
  const bool news_for_others = core_.scheduler().frees_workers() || decision->opened;
  v1::CompleteResponse response = respond(request);
  core_.commit({.entries = std::move(entries),
                .shown = {{.job = entry.id, .results = decision->sequence, .end = false}}},
               [response = std::move(response), done = std::move(done)](const absl::Status& status) {
                 status.ok() ? done(response) : done(status);
               });
  lock.unlock();
  core_.dispatcher().notify_worker(request.worker_id());
  if (news_for_others) core_.dispatcher().notify_work();
}

std::vector<JournalEntry> UnitResults::add(JobEntry& entry, const v1::CompleteRequest& request,
                                           const std::string& digest, v1::UnitStats stats,
                                           const CompleteDecision& decision) {
  const v1::LeaseToken& token = request.token();
  // Nothing takes longer than its lease lasted, nor than its job is old where that is not known.
  const std::chrono::milliseconds lasted =
      decision.lasted.value_or(std::chrono::milliseconds(core_.unix_now() - entry.submitted_unix_ms));
  stats = bounded_by(std::move(stats), lasted, decision.threads);
  const std::string host = core_.scheduler().host_of(request.worker_id());
  const CoveredUnits units = units_of(token);
  add_result(entry, units, host, stats);
  if (!entry.shape->plan->is_of_picture(units.first)) {
    entry.phase_blobs.note(units.first, digest, decision.sequence);
    shares_.forget_upload(digest);
    leases_.claim_upload(digest);
  }
  entry.rate.note(entry.units, core_.now());
  core_.tell(news::ResultAccepted{core_.scheduler().name_of(request.worker_id()), token, time_of(stats),
                                  request.payload().size()});
  std::vector<JournalEntry> entries;
  entries.push_back(UnitDone{.job = entry.id,
                             .sequence = decision.sequence,
                             .units = units,
                             .digest = digest,
                             .payload = request.payload(),
                             .stats = stats.SerializeAsString(),
                             .host = host});
  if (decision.sequence % kResultsBetweenStats == 0) entries.push_back(stats_of(entry));
  entry.result_bytes += request.payload().size();
  return entries;
}

v1::CompleteResponse UnitResults::respond(const v1::CompleteRequest& request) {
  v1::CompleteResponse response;
  if (request.has_beat()) {
    if (auto beaten = leases_.beat(request.worker_id(), request.beat()); beaten.ok())
      *response.mutable_beat() = *std::move(beaten);
  }
  if (request.has_more() && WorkerLeases::names_few(request.more())) {
    if (auto more = leases_.grant(request.worker_id(), request.more()); more.ok())
      *response.mutable_more() = *std::move(more);
  }
  return response;
}

// ---------------------------------------------------------------- failures

absl::StatusOr<JobEntry*> UnitResults::find_open_job(const v1::LeaseToken& token) {
  absl::StatusOr<JobEntry*> entry = core_.find_job(token.job_id());
  if (entry.ok() && (*entry)->past)
    return absl::FailedPreconditionError(absl::StrCat("job ", token.job_id(), " is over"));
  return entry;
}

std::vector<PhaseBlobs::Made> UnitResults::lost(std::vector<PhaseBlobs::Made> blobs) const {
  std::erase_if(blobs,
                [&](const PhaseBlobs::Made& made) { return core_.blobs().query(made.digest).complete; });
  return blobs;
}

void UnitResults::fail(const v1::FailRequest& request, const WorkerOrigin& origin, DoneEmpty done) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  const v1::LeaseToken& token = request.token();
  const std::string& worker = request.worker_id();
  const TimedCall timed(core_, news::Call::kFail);
  std::unique_lock lock(core_.mutex());
  if (absl::Status status = workers_.check(worker, origin); !status.ok()) return done(std::move(status));
  if (absl::Status status = core_.find_job(token.job_id()).status(); !status.ok())
    return done(std::move(status));
  if (absl::Status status = leases_.check_granted(worker, token); !status.ok())
    return done(std::move(status));
  absl::StatusOr<JobEntry*> entry = find_open_job(token);
  if (!entry.ok()) return done(entry.status());
  // A unit that reads what is gone is not to blame: the source is made anew, and the lease is over.
  const PhasePlan& phases = (*entry)->shape->plan->phases();
  if (std::vector<PhaseBlobs::Made> inputs = (*entry)->phase_blobs.inputs(phases, token.unit_index());
      !inputs.empty()) {
    lock.unlock();
    inputs = lost(std::move(inputs));
    lock.lock();
    if (entry = find_open_job(token); !entry.ok()) return done(entry.status());
    for (const PhaseBlobs::Made& made : inputs) {
      static_cast<void>(core_.scheduler().revoke_result(token.job_id(), made.unit, made.sequence,
                                                        absl::StrCat("its blob ", made.digest, " is gone")));
    }
  }
  const FailureReport report{.message = shortened(request.message()),
                             .scene_fault = request.scene_fault(),
                             .inputs_fault = request.inputs_fault(),
                             .log = last_lines(request.log())};
  const absl::Status failed = core_.scheduler().fail(worker, token, report, core_.now());
  if (!failed.ok()) return done(failed);
  workers_.note_failure(worker);
  core_.tell(news::UnitFailed{core_.scheduler().name_of(worker), token, report.message});
  core_.commit({}, std::move(done));
  lock.unlock();
  core_.dispatcher().notify_work();
}

}  // namespace tessera::server
