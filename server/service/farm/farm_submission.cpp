// How a job comes to the farm, and what it takes over from others.
#include "service/farm/farm.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "service/identifier.h"
#include "telemetry/log.h"
#include "wire/arithmetic_class.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

// Specs stay in memory for as long as their jobs are kept.
constexpr std::uint64_t kMaxSpecBytes = std::uint64_t{2} << 30,
                        kMaxSpecBytesOfUser = std::uint64_t{512} << 20;

}  // namespace

absl::StatusOr<std::vector<std::uint64_t>> Farm::blob_sizes(const v1::JobSpec& spec) const {
  std::size_t missing = 0;
  const v1::BlobRef* first = nullptr;
  std::vector<std::uint64_t> sizes;
  for (const v1::BlobRef& blob : spec.farm().blobs()) {
    const UploadState stored = blobs_.query(blob.digest());
    sizes.push_back(stored.stored_bytes);
    if (stored.complete) continue;
    if (missing++ == 0) first = &blob;
  }
  if (missing == 0) return sizes;
  return absl::FailedPreconditionError(absl::StrCat(missing, " blobs are missing; upload them first. One is ",
                                                    first->digest(), " (", first->path(), ")"));
}

absl::Status Farm::check_capacity(const JobShape& shape) const {
  std::uint64_t units = shape.plan->unit_count();
  std::uint64_t bytes = shape.spec_bytes, bytes_of_user = bytes;
  for (const auto& entry : jobs_.all()) {
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
  if (units <= options_.max_open_units) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("with this job's, the jobs that are not over would have ", units, " units, more than the ",
                   options_.max_open_units, " that the coordinator keeps; try again when some are done"));
}

UserShare Farm::share_of(const std::string& user) const {
  UserShare share{.blob_bytes = jobs_.blobs().bytes_of(user) + uploads_.held_by(user)};
  for (const auto& entry : jobs_.all()) {
    if (entry->past || entry->shape->spec.farm().user() != user) continue;
    share.open_jobs += entry->durable_end ? 0 : 1;
    share.units += entry->shape->plan->unit_count();
  }
  return share;
}

UserShare Farm::share_with(const JobShape& shape, const std::vector<std::uint64_t>& sizes) const {
  const std::string& user = shape.spec.farm().user();
  UserShare share = share_of(user);
  ++share.open_jobs;
  share.units += shape.plan->unit_count();
  share.blob_bytes = jobs_.blobs().bytes_with(shape.spec, sizes) + uploads_.held_by(user, shape.spec);
  return share;
}

absl::Status Farm::check_after(const v1::JobSpec& spec) {
  for (const std::string& id : spec.farm().after()) {
    const absl::StatusOr<JobEntry*> other = find_job(id);
    if (!other.ok()) return other.status();
    const v1::JobState state = view_of(**other).state;
    if (state != v1::FAILED && state != v1::CANCELLED) continue;
    return absl::FailedPreconditionError(absl::StrCat("job ", id, ", which has to be done first, ",
                                                      state == v1::FAILED ? "failed" : "was cancelled"));
  }
  return absl::OkStatus();
}

absl::Status Farm::begin_upload(const v1::BlobRef& blob, const Caller& by) {
  if (!by.has_quotas() || blobs_.query(blob.digest()).complete) return absl::OkStatus();
  const std::lock_guard lock(mutex_);
  const std::uint64_t bytes =
      jobs_.blobs().bytes_of(by.user) + uploads_.held_by(by.user, blob.digest()) + blob.size_bytes();
  if (absl::Status s = options_.quotas.check_blob_bytes(by.user, bytes); !s.ok()) return s;
  uploads_.begin(blob.digest(), blob.size_bytes(), by.user, clock_.now());
  return absl::OkStatus();
}

void Farm::note_upload(const std::string& digest, std::uint64_t bytes) {
  metrics_.uploaded(bytes);
  const std::lock_guard lock(mutex_);
  uploads_.note(digest, bytes, clock_.now());
}

absl::StatusOr<const JobEntry*> Farm::best_donor(const v1::SubmitJobRequest& request,
                                                 const v1::JobSpec& spec) {
  // Whether it has results of the kernels asked for.
  const auto has_isa = [&](const JobEntry& entry) {
    const std::vector<std::string> classes = view_of(entry).classes;
    return spec.farm().isa().empty() ||
           std::any_of(classes.begin(), classes.end(),
                       [&](const std::string& name) { return wire::isa_of(name) == spec.farm().isa(); });
  };
  if (const std::string& id = request.continued(); !id.empty()) {
    const absl::StatusOr<JobEntry*> named = find_job(id);
    if (!named.ok()) return named.status();
    std::string difference = difference_in_content((*named)->shape->spec, spec);
    if (const JobView view = view_of(**named);
        difference.empty() && !view.classes.empty() && !has_isa(**named)) {
      difference = absl::StrCat("modified: isa: \"", view.isa, "\" -> \"", spec.farm().isa(), "\"");
    }
    if (difference.empty()) return *named;
    return absl::FailedPreconditionError(
        absl::StrCat("job ", id, " cannot be continued by this one; ", difference));
  }
  const JobEntry* best = nullptr;
  const std::string key = result_key(spec);
  for (const auto& entry : jobs_.all()) {
    const v1::JobSpec& other = entry->shape->spec;
    if (!options_.share_results && other.farm().user() != spec.farm().user()) continue;
    if (entry->durable_results == 0 || entry->shape->key != key ||
        (best != nullptr && best->durable_units >= entry->durable_units)) {
      continue;
    }
    if (has_isa(*entry)) best = entry.get();
  }
  return best;
}

absl::StatusOr<std::optional<Donor>> Farm::find_donor(const v1::SubmitJobRequest& request,
                                                      const JobShape& shape) {
  if (request.fresh()) return std::nullopt;
  Donor donor;
  std::string id;
  {
    const std::lock_guard lock(mutex_);
    if (jobs_.find_request(request_key(shape.spec.farm().user(), request.request_id())) != nullptr)
      return std::nullopt;
    const absl::StatusOr<const JobEntry*> best = best_donor(request, shape.spec);
    if (!best.ok()) return best.status();
    if (*best == nullptr) return std::nullopt;
    id = (*best)->id;
    donor.plan = (*best)->shape->plan;
    donor.named = !request.continued().empty();
  }
  // Thousands of rows, maybe: not under the lock. What was deleted meanwhile is no donor.
  absl::StatusOr<JobRecord> record = journal_.read_job(id);
  if (absl::IsNotFound(record.status())) return std::nullopt;
  if (!record.ok()) return record.status();
  donor.record = *std::move(record);
  const std::vector<std::uint32_t>& roots = donor.plan->phases().roots();
  for (const JobRecord::Result& result : donor.record.results) {
    if (std::binary_search(roots.begin(), roots.end(), result.units.first) &&
        blobs_.query(result.digest).complete)
      donor.blobs.insert(result.digest);
  }
  return donor;
}

absl::StatusOr<std::vector<JournalEntry>> Farm::add_job(JobEntry& entry, const std::optional<Donor>& donor) {
  const v1::JobSpec& spec = entry.shape->spec;
  std::vector<JournalEntry> entries;
  entries.push_back(JobAdded{.id = entry.id,
                             .request_id = entry.request_id,
                             .spec = spec.SerializeAsString(),
                             .generation = entry.generation,
                             .submitted_unix_ms = entry.submitted_unix_ms,
                             .uploaded_bytes = entry.uploaded_bytes});
  if (absl::Status status = scheduler_.add_job(request_of(entry)); !status.ok()) return status;
  telemetry::log(spdlog::level::info, {.job = entry.id, .user = spec.farm().user()},
                 "job {} \"{}\": {} x {} pixels, {} samples, {} units", entry.id, spec.farm().name(),
                 spec.view().width(), spec.view().height(), spec.samples().spp(),
                 entry.shape->plan->unit_count());
  // The donor may have been deleted since it was read, and with it what would be copied.
  if (!donor || jobs_.find(donor->record.added.id) == nullptr) return entries;
  if (absl::Status status = adopt_results(scheduler_, request_of(entry), *donor, entries); !status.ok())
    return status;
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
  if (entry.units > 0) {
    telemetry::log(spdlog::level::info, {.job = entry.id, .user = spec.farm().user()},
                   "job {}: {} units are taken over from job {}", entry.id, entry.units,
                   donor->record.added.id);
  }
  return entries;
}

void Farm::submit(const v1::SubmitJobRequest& request, Done<std::string> done, const Caller& by) {
  if (absl::Status status = check_serving(); !status.ok()) return done(std::move(status));
  if (request.request_id().empty() || request.request_id().size() > wire::kMaxTextBytes) {
    return done(absl::InvalidArgumentError("request_id is empty or too long"));
  }
  v1::JobSpec spec = request.spec();
  spec.mutable_content()->set_build(wire::build_version());
  if (spec.farm().bits() == v1::BITS_UNSPECIFIED) spec.mutable_farm()->set_bits(options_.bits);
  if (spec.farm().isa().empty()) spec.mutable_farm()->set_isa(options_.isa);
  auto shape = JobShape::make(std::move(spec));
  if (!shape.ok()) return done(shape.status());
  if (by.has_quotas()) {
    const absl::Status s = options_.quotas.check_priority(by.user, (*shape)->spec.farm().priority());
    if (!s.ok()) return done(s);
  }
  const absl::StatusOr<std::vector<std::uint64_t>> sizes = blob_sizes(request.spec());
  if (!sizes.ok()) return done(sizes.status());
  if (const std::string& webhook = (*shape)->spec.farm().webhook(); !webhook.empty()) {
    const absl::Status status = options_.listener != nullptr
                                    ? options_.listener->check_webhook(webhook)
                                    : absl::PermissionDeniedError("webhook: the coordinator has none");
    if (!status.ok()) return done(status);
  }
  const absl::StatusOr<std::optional<Donor>> donor = find_donor(request, **shape);
  if (!donor.ok()) return done(donor.status());

  // The journal keeps the spec, and results follow.
  const absl::Status room = blobs_.check_room(request.ByteSizeLong());
  const std::string key = request_key((*shape)->spec.farm().user(), request.request_id());

  std::unique_lock lock(mutex_);
  if (const JobEntry* const known = jobs_.find_request(key)) {
    // Sent a second time: the answer is the same, once the first is durable.
    return commit({}, {}, /*wait=*/true,
                  [id = known->id, done = std::move(done)](const absl::Status& status) {
                    status.ok() ? done(id) : done(status);
                  });
  }
  if (!room.ok()) return done(room);
  if (absl::Status status = check_capacity(**shape); !status.ok()) return done(std::move(status));
  if (by.has_quotas()) {
    const std::string& user = (*shape)->spec.farm().user();
    const absl::Status s = options_.quotas.check_share(user, share_with(**shape, *sizes));
    if (!s.ok()) return done(s);
  }
  if (absl::Status status = check_after((*shape)->spec); !status.ok()) return done(std::move(status));
  std::string id = random_identifier(8);
  while (jobs_.find(id) != nullptr) id = random_identifier(8);
  JobEntry& entry = jobs_.add({.id = id,
                               .request_id = key,
                               .shape = *shape,
                               .submitted_unix_ms = unix_now(),
                               .uploaded_bytes = uploads_.claim((*shape)->spec),
                               .past = std::nullopt,
                               .stats = {},
                               .hosts = {},
                               .units_by_sequence = {},
                               .past_revoked = {}},
                              *sizes);
  absl::StatusOr<std::vector<JournalEntry>> entries = add_job(entry, *donor);
  if (!entries.ok()) return done(entries.status());
  // Workers may begin at once: their results are journaled after the job.
  commit(*std::move(entries), {{.job = id, .results = entry.units_by_sequence.size(), .end = false}},
         /*wait=*/true, [id, done = std::move(done)](const absl::Status& committed) {
           committed.ok() ? done(id) : done(committed);
         });
  lock.unlock();
  dispatcher_.notify_work();
}

}  // namespace tessera::server
