#include "store/commit_queue.h"

#include <iterator>
#include <utility>

namespace tessera::server {
namespace {

std::uint64_t bytes_of(const std::vector<JournalEntry>& entries) {
  std::uint64_t bytes = entries.size() * sizeof(JournalEntry);
  for (const JournalEntry& entry : entries) {
    if (const auto* const unit = std::get_if<UnitDone>(&entry))
      bytes += unit->payload.size() + unit->stats.size();
  }
  return bytes;
}

}  // namespace

CommitQueue::CommitQueue(Journal& journal, base::Clock& clock)
    : journal_(journal), wake_(clock), thread_(clock.start("commits", [this](std::stop_token) { run(); })) {}

CommitQueue::~CommitQueue() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void CommitQueue::push(std::vector<JournalEntry> entries, Done done) {
  {
    const std::lock_guard lock(mutex_);
    waiting_bytes_ += bytes_of(entries);
    items_.push_back({std::move(entries), std::move(done)});
  }
  wake_.notify_one();
}

std::uint64_t CommitQueue::waiting_bytes() const {
  const std::lock_guard lock(mutex_);
  return waiting_bytes_;
}

void CommitQueue::run() {
  absl::Status status;  // the first error until now: whatever waits for a commit that failed has failed, too
  while (true) {
    std::vector<Item> batch;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || !items_.empty(); });
      if (items_.empty()) return;
      batch = std::exchange(items_, {});
    }
    std::vector<JournalEntry> entries;
    for (Item& item : batch) {
      entries.insert(entries.end(), std::make_move_iterator(item.entries.begin()),
                     std::make_move_iterator(item.entries.end()));
    }
    if (status.ok() && !entries.empty()) status = journal_.commit(entries);
    {
      const std::lock_guard lock(mutex_);
      waiting_bytes_ -= bytes_of(entries);
    }
    for (const Item& item : batch) item.done(status);
  }
}

}  // namespace tessera::server
