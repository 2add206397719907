// Journal entries as bytes, for the logs that stand beside the database
// [docs/decisions/0002-journal-format.md].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "store/journal.h"

namespace tessera::server {

/// The payload of a result, which is not logged.
struct PayloadPlace {
  std::uint64_t end = 0;    // offset in the job's result file
  std::uint64_t bytes = 0;  // 0: not known
  std::uint64_t sum = 0;    // checksum(payload, 0)
};

struct LoggedEntry {
  JournalEntry entry;
  PayloadPlace payload;
};

std::string entry_bytes(const JournalEntry& entry, const PayloadPlace& payload);

/// The opposite; nothing for bytes that are no entry. Fields that an older version did not write have their
/// defaults.
std::optional<LoggedEntry> entry_from_bytes(std::string_view bytes);

/// The job whose log has the entry; empty: the farm's log has it, which knows of deleted jobs, too.
const std::string& log_of(const JournalEntry& entry);

}  // namespace tessera::server
