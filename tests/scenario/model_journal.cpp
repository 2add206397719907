#include "scenario/model_journal.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace tessera::server {

JobRecord* ModelJournal::find(const std::string& id) {
  const auto found = std::find_if(records_.begin(), records_.end(),
                                  [&](const JobRecord& record) { return record.added.id == id; });
  return found == records_.end() ? nullptr : &*found;
}

absl::Status ModelJournal::recover(const std::function<absl::Status(JobRecord)>& visit) {
  absl::Status status;
  for (const JobRecord& record : records_) status.Update(visit(record));
  return status;
}

absl::Status ModelJournal::commit(const std::vector<JournalEntry>& entries) {
  for (const JournalEntry& entry : entries) {
    if (const auto* added = std::get_if<JobAdded>(&entry)) {
      JobRecord& record = records_.emplace_back();
      record.added = *added;
      record.ended.id = added->id;
    } else if (const auto* bound = std::get_if<JobBound>(&entry)) {
      find(bound->id)->isa = bound->isa;
    } else if (const auto* ended = std::get_if<JobEnded>(&entry)) {
      find(ended->id)->ended = *ended;
    } else if (const auto* reopened = std::get_if<JobReopened>(&entry)) {
      find(reopened->id)->ended = {.id = reopened->id, .state = 0, .error = "", .finished_unix_ms = 0};
    } else if (const auto* stats = std::get_if<JobStats>(&entry)) {
      find(stats->id)->stats = *stats;
    } else if (const auto* done = std::get_if<UnitDone>(&entry)) {
      JobRecord& record = *find(done->job);
      if (done->sequence != record.results.size() + 1) {
        return absl::InternalError(
            absl::StrCat("job ", done->job, " lacks result ", record.results.size() + 1));
      }
      absl::StatusOr<std::string> payload = done->payload;
      if (!done->from_job.empty()) payload = read_result(done->from_job, done->from_sequence);
      if (!payload.ok()) payload = "";  // a copy of what is lost is as lost
      record.whole_results = ++record.result_count;
      record.result_bytes += payload->size();
      record.results.push_back({.units = done->units,
                                .digest = done->digest,
                                .stats = done->stats,
                                .host = done->host,
                                .bytes = payload->size()});
      payloads_by_job_[done->job].push_back(*std::move(payload));
    } else if (const auto* event = std::get_if<SchedulerEvent>(&entry)) {
      (event->job.empty() ? farm_events_ : find(event->job)->events).push_back(*event);
    } else if (const auto* fetched = std::get_if<JobFetched>(&entry)) {
      find(fetched->id)->fetched = true;
    } else if (const auto* pruned = std::get_if<JobPruned>(&entry)) {
      std::erase_if(records_, [&](const JobRecord& record) { return record.added.id == pruned->id; });
      payloads_by_job_.erase(pruned->id);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<JobRecord> ModelJournal::read_job(const std::string& job) {
  const JobRecord* const record = find(job);
  if (record == nullptr) return absl::NotFoundError(absl::StrCat("there is no job ", job));
  return *record;
}

absl::StatusOr<std::string> ModelJournal::read_result(const std::string& job, std::uint64_t sequence) {
  const auto payloads = payloads_by_job_.find(job);
  if (payloads == payloads_by_job_.end() || sequence == 0 || sequence > payloads->second.size())
    return absl::OutOfRangeError(absl::StrCat("job ", job, " has no result ", sequence));
  return payloads->second[sequence - 1];
}

absl::StatusOr<std::vector<CoveredUnits>> ModelJournal::read_units(const std::string& job,
                                                                   std::uint64_t after, std::uint32_t most) {
  const JobRecord* const record = find(job);
  if (record == nullptr) return absl::NotFoundError(absl::StrCat("there is no job ", job));
  std::vector<CoveredUnits> units;
  for (std::size_t i = after; i < record->results.size() && units.size() < most; ++i)
    units.push_back(record->results[i].units);
  return units;
}

}  // namespace tessera::server
