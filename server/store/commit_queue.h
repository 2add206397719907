// Group commit: what arrives while a commit is under way goes into the next one, together.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "absl/status/status.h"
#include "base/clock.h"
#include "store/journal.h"

namespace tessera::server {

class CommitQueue {
 public:
  /// Called once the entries are durable, or are known not to be; from the queue's own thread, in order.
  /// After an error nothing is committed any more, and everybody gets that error.
  using Done = std::function<void(const absl::Status&)>;

  /// Both must outlive the queue.
  CommitQueue(Journal& journal, base::Clock& clock);
  /// Commits all that is left.
  ~CommitQueue();

  /// Commits in the order of calls; the entries of one call together. No entries: `done` comes after all that
  /// was pushed before is durable.
  void push(std::vector<JournalEntry> entries, Done done);

  /// Bytes of memory that wait, for callers to keep in bounds.
  std::uint64_t waiting_bytes() const;

 private:
  struct Item {
    std::vector<JournalEntry> entries;
    Done done;
  };

  void run();

  Journal& journal_;
  mutable std::mutex mutex_;
  base::Condition wake_;
  std::vector<Item> items_;
  std::uint64_t waiting_bytes_ = 0;
  bool stop_ = false;
  base::Thread thread_;
};

}  // namespace tessera::server
