// Journal of what the coordinator must not forget: jobs, and the results of their units
// [docs/decisions/0002-journal-format.md].
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "store/disk.h"

namespace tessera::server {

/// A job as it was submitted.
struct JobAdded {
  std::string id;
  std::string request_id;  // unique, chosen by the client
  std::string spec;        // serialized JobSpec
  std::uint32_t generation = 1;
  std::int64_t submitted_unix_ms = 0;
  std::uint64_t uploaded_bytes = 0;
};

/// A job's arithmetic class was chosen.
struct JobBound {
  std::string id;
  std::string isa;  // the class; of journals before protocol 2, the ISA alone
};

/// A job is over.
struct JobEnded {
  std::string id;
  int state = 0;  // v1::JobState
  std::string error;
  std::int64_t finished_unix_ms = 0;
};

/// The units that a result covers: so many sample ranges of one tile.
struct CoveredUnits {
  std::uint32_t first = 0;
  std::uint32_t ranges = 1;

  bool operator==(const CoveredUnits&) const = default;
};

/// Units are done. Sequence numbers of a job go up by one from 1, in the order of commits.
struct UnitDone {
  std::string job;
  std::uint64_t sequence = 0;
  CoveredUnits units;
  std::string digest;   // SHA-256 of the decoded result, hexadecimal
  std::string payload;  // proto/wire/tile_result.h
  std::string stats;    // serialized UnitStats
  std::string host;     // the host that rendered it
  // Where these are set, the payload is a copy of that job's result.
  std::string from_job = "";
  std::uint64_t from_sequence = 0;
};

/// Cost of the first `results` results of a job together, so that a restart need not add them up again.
struct JobStats {
  std::string id;
  std::uint64_t results = 0;
  std::string stats;  // serialized UnitStats
};

/// Something of which the scheduler must be told again after a restart; only it knows what the fields mean.
struct SchedulerEvent {
  std::string job;  // empty: of the whole farm
  std::int32_t kind = 0;
  std::uint32_t unit = 0;
  std::int64_t value = 0;
  std::string host;
  std::string text;
};

/// An ended job goes on.
struct JobReopened {
  std::string id;
};

/// A client has all results of an ended job.
struct JobFetched {
  std::string id;
};

/// The job and its results are deleted.
struct JobPruned {
  std::string id;
};

using JournalEntry = std::variant<JobAdded, JobBound, JobEnded, UnitDone, JobStats, SchedulerEvent,
                                  JobReopened, JobFetched, JobPruned>;

/// Everything that was committed about a job but for its payloads.
struct JobRecord {
  JobAdded added;
  std::string isa;  // JobBound::isa
  JobEnded ended;   // state 0 while it is open
  struct Result {
    CoveredUnits units;
    std::string digest;
    std::string stats;
    std::string host;
    std::uint64_t bytes = 0;  // size of its payload
  };
  std::vector<Result> results;  // index: sequence number - 1; empty once the job is over: `stats` covers all
  std::uint64_t result_count = 0;
  JobStats stats;
  std::vector<SchedulerEvent> events;
  bool fetched = false;
  std::uint64_t result_bytes = 0;
  // So many, from the first on, lie within the result file; of jobs that are over all or none. Set by
  // recover().
  std::uint64_t whole_results = 0;
};

/// Safe to use from any number of threads.
class Journal {
 public:
  virtual ~Journal() = default;

  /// One more at each start.
  virtual std::uint64_t epoch() const = 0;

  /// Every job ever added, in that order; costs of single results only where JobRecord::stats does not have
  /// them. To be called once, before the first commit. DataLoss when the data is damaged: opened once more,
  /// the journal is made anew.
  virtual absl::Status recover(const std::function<absl::Status(JobRecord)>& visit) = 0;

  /// Returns what was committed about one job until now. NotFound when there is no such job.
  virtual absl::StatusOr<JobRecord> read_job(const std::string& job) = 0;

  /// Events of the whole farm, in order.
  virtual absl::StatusOr<std::vector<SchedulerEvent>> farm_events() = 0;

  /// All entries or none; durable when it returns OK. After an error nothing more is taken, for it is not
  /// known what reached the disk.
  virtual absl::Status commit(const std::vector<JournalEntry>& entries) = 0;

  /// The payload of a committed result. OutOfRange when there is none of that number.
  virtual absl::StatusOr<std::string> read_result(const std::string& job, std::uint64_t sequence) = 0;

  /// Units of at most `most` committed results after the number `after`, in order.
  virtual absl::StatusOr<std::vector<CoveredUnits>> read_units(const std::string& job, std::uint64_t after,
                                                               std::uint32_t most) = 0;

  /// Costs of these results: serialized UnitStats, in order. Unimplemented where that is not kept.
  virtual absl::StatusOr<std::vector<std::string>> read_stats(const std::string& /*job*/,
                                                              std::uint64_t /*after*/,
                                                              std::uint32_t /*most*/) {
    return absl::UnimplementedError("this journal does not keep what single results cost");
  }
};

struct JournalOptions {
  /// Goes on with what there is when something is lost that was committed.
  bool accept_loss = false;
};

/// Opens the journal of a data directory, made when there is nothing yet; an empty path: in memory. Tables
/// that are damaged are made anew from the logs that stand beside the results, and the damaged ones kept as
/// journal.sqlite.damaged. FailedPrecondition when a newer version wrote it, and when something that was
/// committed is lost, with what; DataLoss when the tables are damaged and there are no logs.
absl::StatusOr<std::unique_ptr<Journal>> open_journal(const std::filesystem::path& data_dir,
                                                      const JournalOptions& options = {},
                                                      Disk& disk = machine_disk());

}  // namespace tessera::server
