#include "service/job/journal_events.h"

#include <algorithm>
#include <optional>

#include "absl/strings/str_cat.h"
#include "service/job/result_check.h"

namespace tessera::server {
namespace {

using EventKind = FarmEvent::Kind;

FarmEvent from_journal(const SchedulerEvent& entry) {
  return {.kind = static_cast<EventKind>(entry.kind),
          .job = entry.job,
          .unit = entry.unit,
          .value = entry.value,
          .host = entry.host,
          .text = entry.text};
}

SchedulerEvent plain(const FarmEvent& event) {
  return {.job = event.job,
          .kind = static_cast<std::int32_t>(event.kind),
          .unit = event.unit,
          .value = event.value,
          .host = event.host,
          .text = event.text};
}

}  // namespace

void append_to_journal(const FarmEvent& event, std::int64_t now_unix_ms, std::vector<JournalEntry>& entries) {
  switch (event.kind) {
    case EventKind::kBound:
      entries.push_back(JobBound{.id = event.job, .isa = event.text});
      return;
    case EventKind::kEnded:
      entries.push_back(JobEnded{.id = event.job,
                                 .state = static_cast<int>(event.value),
                                 .error = event.text,
                                 .finished_unix_ms = now_unix_ms});
      return;
    case EventKind::kReopened:
      entries.push_back(JobReopened{.id = event.job});
      break;
    default:
      break;
  }
  entries.push_back(plain(event));
}

std::vector<std::uint64_t> revoked_results(const JobRecord& record) {
  std::vector<std::uint64_t> sequences;
  for (const SchedulerEvent& event : record.events) {
    if (static_cast<EventKind>(event.kind) == EventKind::kRevoked)
      sequences.push_back(static_cast<std::uint64_t>(event.value));
  }
  std::sort(sequences.begin(), sequences.end());
  return sequences;
}

ClassHistory classes_of(const JobRecord& record) {
  ClassHistory classes(record.isa);
  for (const SchedulerEvent& event : record.events) {
    if (static_cast<EventKind>(event.kind) != EventKind::kClassNoted) continue;
    classes.note(event.host, static_cast<std::uint32_t>(event.value), event.text);
  }
  return classes;
}

absl::Status restore_job(Scheduler& scheduler, JobRequest request, const JobRecord& record) {
  const std::string id = request.id;
  const std::shared_ptr<const WorkPlan> plan = request.plan;
  request.bound_class = record.isa;
  absl::Status status = scheduler.add_job(std::move(request));
  const std::vector<std::uint64_t> revoked = revoked_results(record);
  for (std::size_t i = 0; i < record.results.size(); ++i) {
    const JobRecord::Result& result = record.results[i];
    const std::uint64_t sequence = i + 1;
    if (std::binary_search(revoked.begin(), revoked.end(), sequence)) {
      status.Update(scheduler.restore_revoked(id, static_cast<std::uint32_t>(sequence)));
      continue;
    }
    const std::optional<UnitRun> units = plan->run(result.units.first, result.units.ranges);
    if (!units) {
      status.Update(absl::InvalidArgumentError(absl::StrCat("job ", id, " has no unit ", result.units.first,
                                                            " of ", result.units.ranges, " ranges")));
      break;
    }
    status.Update(scheduler.restore_done(id, {.fingerprint = fingerprint_of(result.digest),
                                              .sequence = static_cast<std::uint32_t>(sequence),
                                              .host = scheduler.number_of_host(result.host),
                                              .units = *units}));
  }
  for (const SchedulerEvent& event : record.events) status.Update(scheduler.restore(from_journal(event)));
  if (status.ok()) status.Update(scheduler.restored(id));
  return status;
}

absl::Status restore_farm(Scheduler& scheduler, Journal& journal) {
  const absl::StatusOr<std::vector<SchedulerEvent>> events = journal.farm_events();
  if (!events.ok()) return events.status();
  absl::Status status;
  for (const SchedulerEvent& event : *events) status.Update(scheduler.restore(from_journal(event)));
  return status;
}

}  // namespace tessera::server
