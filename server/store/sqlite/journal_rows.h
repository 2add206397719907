// Reading the journal's tables. Every call throws SQLite::Exception.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "store/journal.h"

namespace tessera::server {

class JournalRows {
 public:
  explicit JournalRows(SQLite::Database& database) : database_(database) {}

  /// Rows of all jobs, in the order of submission.
  std::vector<std::string> ids();
  /// A job without its results and events.
  std::optional<JobRecord> job(const std::string& id);
  /// All of them, in the order of submission, until one is an error.
  absl::Status jobs(const std::function<absl::Status(JobRecord)>& visit);

  /// How many results a job has; in the second, also where the last ends, for `record`.
  std::uint64_t result_count(const std::string& job);
  void count_results(JobRecord& record);
  /// Adds a job's results and events to its record, and says where the payloads end. Costs of the first
  /// `known` results are not needed. DataLoss when one lacks.
  absl::StatusOr<std::vector<std::uint64_t>> read_results(JobRecord& record, std::uint64_t known);
  /// Where results end whose numbers are `first` to `last`, in order.
  std::vector<std::uint64_t> ends(const std::string& job, std::uint64_t first, std::uint64_t last);
  /// Units of at most `most` results after the number `after`, in order.
  std::vector<CoveredUnits> units(const std::string& job, std::uint64_t after, std::uint32_t most);
  /// Costs of these results.
  std::vector<std::string> stats(const std::string& job, std::uint64_t after, std::uint32_t most);
  /// Returns events in order; of the whole farm for an empty `job`.
  std::vector<SchedulerEvent> events(const std::string& job);

  /// A number that the journal keeps of itself.
  std::uint64_t meta(const char* key);
  /// How many bytes of the job's log are in the tables; nothing when it has no log yet.
  std::optional<std::uint64_t> log_bytes(const std::string& job);

 private:
  SQLite::Database& database_;
};

}  // namespace tessera::server
