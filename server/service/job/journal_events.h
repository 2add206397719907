// Between the scheduler, which knows what must be durable, and the journal, which makes it so.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "scheduler/scheduler.h"
#include "store/journal.h"

namespace tessera::server {

/// Appends what has to be journaled for an event. `now_unix_ms` is when a job ended, if that is what the
/// event says.
void append_to_journal(const FarmEvent& event, std::int64_t now_unix_ms, std::vector<JournalEntry>& entries);

/// Tells a new scheduler everything about a job that has not ended, or is incomplete. `request.isa` is what
/// the job asks for; what it was bound to is in the record. What has to be journaled after that is among the
/// scheduler's events.
absl::Status restore_job(Scheduler& scheduler, JobRequest request, const JobRecord& record);

/// Tells a new scheduler which hosts are not trusted. Before any job.
absl::Status restore_farm(Scheduler& scheduler, Journal& journal);

/// The sequence numbers of results that do not count any more, ascending.
std::vector<std::uint64_t> revoked_results(const JobRecord& record);

/// Returns the arithmetic classes that the results were made in.
ClassHistory classes_of(const JobRecord& record);

}  // namespace tessera::server
