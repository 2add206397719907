#include "service/farm/job_submission.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "service/farm/farm_core.h"
#include "service/farm/user_shares.h"
#include "service/job/end_listener.h"
#include "wire/arithmetic_class.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

// Specs stay in memory for as long as their jobs are kept.
constexpr std::uint64_t kMaxSpecBytes = std::uint64_t{2} << 30,
                        kMaxSpecBytesOfUser = std::uint64_t{512} << 20;

}  // namespace

absl::StatusOr<std::vector<std::uint64_t>> JobSubmission::blob_sizes(const v1::JobSpec& spec) const {
  std::size_t missing = 0;
  const v1::BlobRef* first = nullptr;
  std::vector<std::uint64_t> sizes;
  for (const v1::BlobRef& blob : spec.farm().blobs()) {
    const UploadState stored = core_.blobs().query(blob.digest());
    sizes.push_back(stored.stored_bytes);
    if (stored.complete) continue;
    if (missing++ == 0) first = &blob;
  }
  if (missing == 0) return sizes;
  return absl::FailedPreconditionError(absl::StrCat(missing, " blobs are missing; upload them first. One is ",
                                                    first->digest(), " (", first->path(), ")"));
}

absl::Status JobSubmission::check_capacity(const JobShape& shape) const {
  std::uint64_t units = shape.plan->unit_count();
  std::uint64_t bytes = shape.spec_bytes, bytes_of_user = bytes;
  for (const auto& entry : core_.jobs().all()) {
    units += entry->past ? 0 : entry->shape->plan->unit_count();
    bytes += entry->shape->spec_bytes;
    if (entry->shape->spec.farm().user() == shape.spec.farm().user())
      bytes_of_user += entry->shape->spec_bytes;
  }
  if (bytes > kMaxSpecBytes || bytes_of_user > kMaxSpecBytesOfUser) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "with this job's, the specs of the jobs that are kept would have ", bytes, " bytes, and those of '",
        shape.spec.farm().user(), "' ", bytes_of_user, "; at most ", kMaxSpecBytes, " and ",
        kMaxSpecBytesOfUser, " are taken; try again when old jobs are deleted"));
  }
  if (units <= core_.options().max_open_units) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat(
      "with this job's, the jobs that are not over would have ", units, " units, more than the ",
      core_.options().max_open_units, " that the coordinator keeps; try again when some are done"));
}

absl::Status JobSubmission::check_after(const v1::JobSpec& spec) {
  for (const std::string& id : spec.farm().after()) {
    const absl::StatusOr<JobEntry*> other = core_.find_job(id);
    if (!other.ok()) return other.status();
    const v1::JobState state = core_.view_of(**other).state;
    if (state != v1::FAILED && state != v1::CANCELLED) continue;
    return absl::FailedPreconditionError(absl::StrCat("job ", id, ", which has to be done first, ",
                                                      state == v1::FAILED ? "failed" : "was cancelled"));
  }
  return absl::OkStatus();
}

absl::StatusOr<const JobEntry*> JobSubmission::best_donor(const v1::SubmitJobRequest& request,
                                                          const v1::JobSpec& spec) {
  // Whether it has results of the kernels asked for.
  const auto has_isa = [&](const JobEntry& entry) {
    const std::vector<std::string> classes = core_.view_of(entry).classes;
    return spec.farm().isa().empty() ||
           std::any_of(classes.begin(), classes.end(),
                       [&](const std::string& name) { return wire::isa_of(name) == spec.farm().isa(); });
  };
  if (const std::string& id = request.continued(); !id.empty()) {
    const absl::StatusOr<JobEntry*> named = core_.find_job(id);
    if (!named.ok()) return named.status();
    std::string difference = difference_in_content((*named)->shape->spec, spec);
    if (const JobView view = core_.view_of(**named);
        difference.empty() && !view.classes.empty() && !has_isa(**named)) {
      difference = absl::StrCat("modified: isa: \"", view.isa, "\" -> \"", spec.farm().isa(), "\"");
    }
    if (difference.empty()) return *named;
    return absl::FailedPreconditionError(
        absl::StrCat("job ", id, " cannot be continued by this one; ", difference));
  }
  const JobEntry* best = nullptr;
  const std::string key = result_key(spec);
  for (const auto& entry : core_.jobs().all()) {
    const v1::JobSpec& other = entry->shape->spec;
    if (!core_.options().share_results && other.farm().user() != spec.farm().user()) continue;
    if (entry->durable_results == 0 || entry->shape->key != key ||
        (best != nullptr && best->durable_units >= entry->durable_units)) {
      continue;
    }
    if (has_isa(*entry)) best = entry.get();
  }
  return best;
}

absl::StatusOr<std::optional<Donor>> JobSubmission::find_donor(const v1::SubmitJobRequest& request,
                                                               const JobShape& shape) {
  if (request.fresh()) return std::nullopt;
  Donor donor;
  std::string id;
  {
    const std::lock_guard lock(core_.mutex());
    if (core_.jobs().find_request(request_key(shape.spec.farm().user(), request.request_id())) != nullptr)
      return std::nullopt;
    const absl::StatusOr<const JobEntry*> best = best_donor(request, shape.spec);
    if (!best.ok()) return best.status();
    if (*best == nullptr) return std::nullopt;
    id = (*best)->id;
    donor.plan = (*best)->shape->plan;
    donor.named = !request.continued().empty();
  }
  // Thousands of rows, maybe: not under the lock. What was deleted meanwhile is no donor.
  absl::StatusOr<JobRecord> record = core_.journal().read_job(id);
  if (absl::IsNotFound(record.status())) return std::nullopt;
  if (!record.ok()) return record.status();
  donor.record = *std::move(record);
  const std::vector<std::uint32_t>& roots = donor.plan->phases().roots();
  for (const JobRecord::Result& result : donor.record.results) {
    if (std::binary_search(roots.begin(), roots.end(), result.units.first) &&
        core_.blobs().query(result.digest).complete)
      donor.blobs.insert(result.digest);
  }
  return donor;
}

absl::Status JobSubmission::check_webhook(const std::string& webhook) const {
  if (webhook.empty()) return absl::OkStatus();
  const EndListener* const listener = core_.options().listener;
  return listener != nullptr ? listener->check_webhook(webhook)
                             : absl::PermissionDeniedError("webhook: the coordinator has none");
}

absl::StatusOr<JobSubmission::Candidate> JobSubmission::check(const v1::SubmitJobRequest& request,
                                                              const Caller& by) {
  if (request.request_id().empty() || request.request_id().size() > wire::kMaxTextBytes)
    return absl::InvalidArgumentError("request_id is empty or too long");
  v1::JobSpec spec = request.spec();
  spec.mutable_content()->set_build(wire::build_version());
  if (spec.farm().bits() == v1::BITS_UNSPECIFIED) spec.mutable_farm()->set_bits(core_.options().bits);
  if (spec.farm().isa().empty()) spec.mutable_farm()->set_isa(core_.options().isa);
  auto shape = JobShape::make(std::move(spec));
  if (!shape.ok()) return shape.status();
  const v1::JobSpec::Farm& farm = (*shape)->spec.farm();
  if (absl::Status s = shares_.check_priority(by, farm.priority()); !s.ok()) return s;
  absl::StatusOr<std::vector<std::uint64_t>> sizes = blob_sizes(request.spec());
  if (!sizes.ok()) return sizes.status();
  if (absl::Status s = check_webhook(farm.webhook()); !s.ok()) return s;
  absl::StatusOr<std::optional<Donor>> donor = find_donor(request, **shape);
  if (!donor.ok()) return donor.status();
  // The journal keeps the spec, and results follow.
  return Candidate{.shape = *std::move(shape),
                   .blob_sizes = *std::move(sizes),
                   .donor = *std::move(donor),
                   .room = core_.blobs().check_room(request.ByteSizeLong())};
}

void JobSubmission::submit(const v1::SubmitJobRequest& request, Done<std::string> done, const Caller& by) {
  if (absl::Status status = core_.check_serving(); !status.ok()) return done(std::move(status));
  const absl::StatusOr<Candidate> candidate = check(request, by);
  if (!candidate.ok()) return done(candidate.status());
  const JobShape& shape = *candidate->shape;
  const std::string key = request_key(shape.spec.farm().user(), request.request_id());

  std::unique_lock lock(core_.mutex());
  if (const JobEntry* const known = core_.jobs().find_request(key)) {
    // Sent a second time: the answer is the same, once the first is durable.
    return core_.commit({}, [id = known->id, done = std::move(done)](const absl::Status& status) {
      status.ok() ? done(id) : done(status);
    });
  }
  absl::Status status = candidate->room;
  if (status.ok()) status = check_capacity(shape);
  if (status.ok()) status = shares_.check_new_job(by, shape, candidate->blob_sizes);
  if (status.ok()) status = check_after(shape.spec);
  if (!status.ok()) return done(std::move(status));

  JobEntry& entry = add_entry(*candidate, key);
  absl::StatusOr<std::vector<JournalEntry>> entries = schedule(entry, candidate->donor);
  if (!entries.ok()) {
    core_.jobs().erase(entry.id);
    return done(entries.status());
  }
  // Workers may begin at once: their results are journaled after the job.
  core_.commit({.entries = *std::move(entries),
                .shown = {{.job = entry.id, .results = entry.units_by_sequence.size(), .end = false}}},
               [id = entry.id, done = std::move(done)](const absl::Status& committed) {
                 committed.ok() ? done(id) : done(committed);
               });
  lock.unlock();
  core_.dispatcher().notify_work();
}

JobEntry& JobSubmission::add_entry(const Candidate& candidate, const std::string& key) {
  std::string id = core_.options().make_identifier(8);
  while (core_.jobs().find(id) != nullptr) id = core_.options().make_identifier(8);
  return core_.jobs().add({.id = std::move(id),
                           .request_id = key,
                           .shape = candidate.shape,
                           .submitted_unix_ms = core_.unix_now(),
                           .uploaded_bytes = 0,
                           .past = std::nullopt,
                           .stats = {},
                           .hosts = {},
                           .units_by_sequence = {},
                           .past_revoked = {}},
                          candidate.blob_sizes);
}

absl::StatusOr<std::vector<JournalEntry>> JobSubmission::schedule(JobEntry& entry,
                                                                  const std::optional<Donor>& donor) {
  if (absl::Status status = core_.scheduler().add_job(request_of(entry)); !status.ok()) return status;
  entry.uploaded_bytes = shares_.claim_uploads(entry.shape->spec);
  std::vector<JournalEntry> entries;
  entries.push_back(JobAdded{.id = entry.id,
                             .request_id = entry.request_id,
                             .spec = entry.shape->spec.SerializeAsString(),
                             .generation = entry.generation,
                             .submitted_unix_ms = entry.submitted_unix_ms,
                             .uploaded_bytes = entry.uploaded_bytes});
  core_.tell(news::JobSubmitted{entry});
  // The donor may have been deleted since it was read, and with it what would be copied.
  if (!donor || core_.jobs().find(donor->record.added.id) == nullptr) return entries;
  if (absl::Status status = adopt_results(core_.scheduler(), request_of(entry), *donor, entries);
      !status.ok()) {
    // The job is here, and is rendered without them.
    core_.tell(news::JobNoted{
        entry, absl::StrCat("takes over nothing from job ", donor->record.added.id, ": ", status.message())});
    return entries;
  }
  for (const JournalEntry& journaled : entries) {
    const auto* const done = std::get_if<UnitDone>(&journaled);
    if (done == nullptr) continue;
    v1::UnitStats stats;
    static_cast<void>(stats.ParseFromString(done->stats));
    add_result(entry, done->units, done->host, stats);
    if (!entry.shape->plan->is_of_picture(done->units.first))
      entry.phase_blobs.note(done->units.first, done->digest, done->sequence);
    entry.result_bytes += donor->record.results[done->from_sequence - 1].bytes;
  }
  if (entry.units > 0) core_.tell(news::ResultsAdopted{entry, donor->record.added.id});
  return entries;
}

}  // namespace tessera::server
