// Results that are there already are not rendered again: a job of equal content gets them from the store.
#pragma once

#include <string>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "scheduler/scheduler.h"
#include "store/journal.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// Names the difference between two jobs in that on which results depend, besides the number of samples and
/// the ISA: the field and both values. Empty when units of the same pixels and samples have the same results
/// in both.
std::string difference_in_content(const v1::JobSpec& a, const v1::JobSpec& b);

/// Key of that on which the results of units depend: equal where there is no such difference.
std::string result_key(const v1::JobSpec& spec);

/// A job with results, as the journal has it.
struct Donor {
  JobRecord record;
  std::shared_ptr<const WorkPlan> plan;
  bool named = false;  // whoever submits the job wants it to go on from this one
  /// Digests of the blobs that its phases made in the end, as far as they are there.
  absl::flat_hash_set<std::string> blobs = {};
};

/// Gives the new job all results of the donor that are of its own units and whose hosts are trusted, and of
/// one arithmetic class if the job is to be: of which there are most. Where nobody could go on in that class,
/// and the donor was not named, none. Where the donor's phases were not all made, or a phase's blob is
/// gone, none either. Both have equal content. Appends what is to be journaled behind the job
/// itself, besides the scheduler's events: UnitDone entries, numbered from 1. After an error, which is that
/// of Scheduler::adopt, the job and the entries are as they were.
absl::Status adopt_results(Scheduler& scheduler, const JobRequest& job, const Donor& donor,
                           std::vector<JournalEntry>& entries);

}  // namespace tessera::server
