#include "service/farm/job_keeper.h"

#include <iterator>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

// A clock that is set by less is one that is kept right.
constexpr Time kStep{std::chrono::minutes{1}};
// A coordinator that is killed loses the time lived through since, and keeps its jobs for so much longer.
constexpr Time kBetweenSavings{std::chrono::minutes{1}};
// Uploads that no job came of leave blobs behind even when no job is deleted.
constexpr Time kLongestBetweenCollections{std::chrono::hours{1}};

void save(const LivedTime& lived, const std::string& text) {
  if (absl::Status status = LivedTime::save(lived.file(), text); !status.ok()) {
    spdlog::error("{}", std::string(status.message()));
  }
}

}  // namespace

JobKeeper::JobKeeper(const Retention& retention, BlobStore& blobs, base::Clock& clock,
                     std::filesystem::path lived_time)
    : retention_(retention),
      blobs_(blobs),
      clock_(clock),
      lived_(std::move(lived_time)),
      next_collection_(now() + kLongestBetweenCollections) {}

Time JobKeeper::now() const { return std::chrono::duration_cast<Time>(clock_.now().time_since_epoch()); }

void JobKeeper::live_on() {
  const Time set = lived_.advance(now(), clock_.wall());
  if (set < -kStep || set > kStep) {
    spdlog::warn("the machine's clock was set by {} s; jobs and blobs are kept for as long as without that",
                 std::chrono::duration_cast<std::chrono::seconds>(set).count());
    // When a blob was used last is the file system's word, by the clock on the wall.
    no_collection_before_ = now() + std::chrono::duration_cast<Time>(retention_.blobs);
  }
}

bool JobKeeper::is_due() {
  if (now() < next_look_) return false;
  next_look_ = now() + retention_.interval;
  return true;
}

std::vector<std::string> JobKeeper::old_jobs(const JobTable& jobs, const StateOf& state_of) {
  std::uint64_t bytes = 0;
  for (const auto& entry : jobs.all()) bytes += entry->result_bytes;
  std::vector<std::string> old;
  for (const auto& entry : jobs.all()) {
    if (!entry->durable_end) {
      lived_.forget(entry->id);
      continue;
    }
    const Time age = lived_.since_end_of(entry->id);
    const v1::JobState state = state_of(*entry);
    const bool kept_for_nobody =
        (entry->fetched && state == v1::DONE) || state == v1::FAILED || state == v1::CANCELLED;
    const bool too_much = kept_for_nobody && bytes > retention_.max_bytes;
    if (!too_much && age < (kept_for_nobody ? retention_.fetched : retention_.unfetched)) continue;
    bytes -= entry->result_bytes;
    old.push_back(entry->id);
  }
  return old;
}

void JobKeeper::clean_up(const JobTable& jobs, bool jobs_went) {
  if (now() >= no_collection_before_ && (jobs_went || now() >= next_collection_)) collect_blobs(jobs);
  drop_blobs();
  if (lived_.file().empty() || now() < next_saving_ || saving_.exchange(true)) return;
  next_saving_ = now() + kBetweenSavings;
  saver_ = clock_.start("saver", [this, text = lived_.to_text()](std::stop_token) {
    save(lived_, text);
    saving_ = false;
  });
}

void JobKeeper::collect_blobs(const JobTable& jobs) {
  if (collecting_.exchange(true)) return;
  next_collection_ = now() + kLongestBetweenCollections;
  // Blobs of a job that is submitted meanwhile were asked for a moment ago.
  absl::flat_hash_set<std::string> needed;
  for (const auto& entry : jobs.all()) {
    for (const v1::BlobRef& blob : entry->shape->spec.farm().blobs()) needed.insert(blob.digest());
    entry->phase_blobs.for_each_digest([&](std::string digest) { needed.insert(std::move(digest)); });
  }
  collector_ = clock_.start("collector", [this, needed = std::move(needed)](std::stop_token) {
    const BlobStore::Collected collected =
        blobs_.collect([&](const std::string& digest) { return needed.contains(digest); }, retention_.blobs);
    if (collected.blobs > 0) {
      spdlog::info("{} blobs ({} bytes) are deleted: no job needs them", collected.blobs, collected.bytes);
    }
    collecting_ = false;
  });
}

void JobKeeper::drop_unused(std::vector<std::string> blobs, std::chrono::seconds unused) {
  blobs_to_drop_.insert(blobs_to_drop_.end(), std::make_move_iterator(blobs.begin()),
                        std::make_move_iterator(blobs.end()));
  unused_for_ = unused;
}

void JobKeeper::drop_blobs() {
  if (blobs_to_drop_.empty() || collecting_.exchange(true)) return;
  collector_ = clock_.start(
      "collector", [this, blobs = std::exchange(blobs_to_drop_, {}), unused = unused_for_](std::stop_token) {
        std::size_t dropped = 0;
        for (const std::string& digest : blobs) dropped += blobs_.drop_unused(digest, unused) ? 1 : 0;
        if (dropped > 0) spdlog::info("{} blobs of workers are deleted: no result named them", dropped);
        collecting_ = false;
      });
}

void JobKeeper::stop() {
  live_on();
  if (saver_.joinable()) saver_.join();
  save(lived_, lived_.to_text());
}

}  // namespace tessera::server
