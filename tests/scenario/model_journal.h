// A journal that is a list of records in memory: what the real one means, without how it does it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "store/journal.h"

namespace tessera::server {

class ModelJournal final : public Journal {
 public:
  /// The coordinator starts again.
  void begin_epoch() { ++epoch_; }

  std::uint64_t epoch() const override { return epoch_; }
  absl::Status recover(const std::function<absl::Status(JobRecord)>& visit) override;
  absl::StatusOr<JobRecord> read_job(const std::string& job) override;
  absl::StatusOr<std::vector<SchedulerEvent>> farm_events() override { return farm_events_; }
  absl::Status commit(const std::vector<JournalEntry>& entries) override;
  absl::StatusOr<std::string> read_result(const std::string& job, std::uint64_t sequence) override;
  absl::StatusOr<std::vector<CoveredUnits>> read_units(const std::string& job, std::uint64_t after,
                                                       std::uint32_t most) override;

 private:
  JobRecord* find(const std::string& id);

  std::uint64_t epoch_ = 0;
  std::vector<JobRecord> records_;
  std::vector<SchedulerEvent> farm_events_;
  std::map<std::string, std::vector<std::string>> payloads_by_job_;
};

}  // namespace tessera::server
