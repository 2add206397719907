// Group commit: what arrives while a commit is under way goes into the next one, together.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "store/journal.h"

namespace tessera::server {

class CommitQueue {
 public:
  /// Called once the entries are durable, or are known not to be; from the queue's own thread, in order.
  using Done = std::function<void(const absl::Status&)>;

  /// `journal` must outlive the queue.
  explicit CommitQueue(Journal& journal);
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
  std::condition_variable wake_;
  std::vector<Item> items_;
  std::uint64_t waiting_bytes_ = 0;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace tessera::server
