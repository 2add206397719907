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
    } else if (const auto* done = std::get_if<UnitDone>(&entry)) {
      JobRecord& record = *find(done->job);
      if (done->sequence != record.results.size() + 1) {
        return absl::InternalError(
            absl::StrCat("job ", done->job, " lacks result ", record.results.size() + 1));
      }
      ++record.result_count;
      record.results.push_back(
          {.units = done->units, .digest = done->digest, .stats = done->stats, .host = done->host});
    } else if (const auto* event = std::get_if<SchedulerEvent>(&entry)) {
      (event->job.empty() ? farm_events_ : find(event->job)->events).push_back(*event);
    } else if (const auto* fetched = std::get_if<JobFetched>(&entry)) {
      find(fetched->id)->fetched = true;
    } else if (const auto* pruned = std::get_if<JobPruned>(&entry)) {
      std::erase_if(records_, [&](const JobRecord& record) { return record.added.id == pruned->id; });
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
  return absl::UnimplementedError("the model keeps no payloads");
}

absl::StatusOr<std::vector<CoveredUnits>> ModelJournal::read_units(const std::string&, std::uint64_t,
                                                                   std::uint32_t) {
  return absl::UnimplementedError("nobody fetches from the model");
}

}  // namespace tessera::server
