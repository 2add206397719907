#include "store/log/commit_logs.h"

#include <utility>

#include "store/data_dir.h"

namespace tessera::server {

EntryLog& CommitLogs::log(const std::string& job) {
  std::unique_ptr<EntryLog>& log = logs_[job];
  if (log == nullptr) {
    log = std::make_unique<EntryLog>(disk_, log_path(data_dir_, job), rows_.log_bytes(job).value_or(0));
  }
  return *log;
}

absl::Status CommitLogs::append(CommitStamp stamp, const std::vector<JournalEntry>& entries,
                                const std::vector<PayloadPlace>& payloads) {
  stamp.entries = static_cast<std::uint32_t>(entries.size());
  absl::Status status;
  for (std::size_t i = 0; i < entries.size() && status.ok(); ++i) {
    const std::string& job = log_of(entries[i]);
    EntryLog& log = this->log(job);
    touched_logs_[job] = &log;
    status = log.open();
    stamp.index = static_cast<std::uint32_t>(i);
    if (status.ok()) log.append(stamp, entries[i], payloads[i]);
  }
  for (const auto& [job, log] : touched_logs_) {
    if (status.ok()) status = log->flush();
  }
  return status;
}

std::vector<DiskFile*> CommitLogs::files_to_sync() const {
  std::vector<DiskFile*> files;
  for (const auto& [job, log] : touched_logs_) files.push_back(log->file_to_sync());
  return files;
}

void CommitLogs::write_reach(JournalTables& tables) const {
  for (const auto& [job, log] : touched_logs_) tables.write_log(job, log->appended_bytes());
}

void CommitLogs::keep() {
  for (const auto& [job, log] : touched_logs_) log->keep();
  touched_logs_.clear();
}

void CommitLogs::drop() {
  for (const auto& [job, log] : touched_logs_) log->drop();
  touched_logs_.clear();
}

void CommitLogs::remove(const std::string& job) {
  logs_.erase(job);
  static_cast<void>(disk_.remove(log_path(data_dir_, job)));
}

}  // namespace tessera::server
