#include "agent/stores/prepared_store.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "agent/stores/or_exhausted.h"
#include "net/backoff.h"
#include "net/status.h"
#include "wire/digest.h"

namespace tessera::agent {

/// With it, what it reads from stays.
std::shared_ptr<const render::Prepared> PreparedStore::whole(const std::shared_ptr<Slot>& slot) {
  return {slot, slot->prepared.get()};
}

absl::StatusOr<render::BlobBytes> PreparedStore::fetch(const std::string& digest, std::stop_token stop) {
  if (fetcher_ != nullptr) return fetcher_->get(digest, stop);
  net::Backoff backoff{std::chrono::milliseconds{100}, std::chrono::milliseconds{2000}};
  while (true) {
    const auto bytes = std::make_shared<std::string>();
    const auto sink = [&](std::string_view chunk) {
      bytes->append(chunk);
      return absl::OkStatus();
    };
    absl::Status status = link_.download({.digest = digest}, sink, stop);
    if (status.ok() && wire::sha256_hex(*bytes) != digest)
      status = absl::DataLossError(absl::StrCat("blob ", digest, " came with other bytes"));
    if (status.ok()) return render::BlobBytes{*bytes, bytes};
    if (!net::is_transient(status) || !link_.wait(backoff, stop)) return status;
  }
}

absl::StatusOr<Inputs> PreparedStore::fetch(const std::string& job_id, const v1::WorkUnit& unit,
                                            std::stop_token stop) {
  {
    const std::lock_guard lock{mutex_};
    for (const v1::BlobRef& input : unit.inputs()) read_[job_id].insert(input.digest());
  }
  Inputs inputs;
  for (const v1::BlobRef& input : unit.inputs()) {
    absl::StatusOr<render::BlobBytes> blob = fetch(input.digest(), stop);
    if (!blob.ok()) return blob.status();
    inputs.blob_contents.push_back(blob->bytes);
    inputs.blobs.push_back(*std::move(blob));
  }
  return inputs;
}

absl::StatusOr<std::shared_ptr<const render::Prepared>> PreparedStore::get(
    const std::string& job_id, const v1::WorkUnit& unit, const std::shared_ptr<const LoadedScene>& scene,
    std::stop_token stop) {
  if (unit.inputs().empty()) return nullptr;
  std::vector<std::string> digests;
  for (const v1::BlobRef& input : unit.inputs()) digests.push_back(input.digest());

  std::unique_lock lock{mutex_};
  const auto find = [&] {
    return std::find_if(slots_.begin(), slots_.end(),
                        [&](const auto& slot) { return slot->scene == scene && slot->digests == digests; });
  };
  // Where whoever prepares it fails, the next one tries.
  for (auto found = find(); found != slots_.end(); found = find()) {
    slots_.splice(slots_.begin(), slots_, found);
    const std::shared_ptr<Slot> slot = slots_.front();
    if (slot->prepared != nullptr) return whole(slot);
    // Another thread may have begun anew before this one wakes.
    const auto is_over = [&] {
      const auto now = find();
      return slot->prepared != nullptr || now == slots_.end() || *now != slot;
    };
    if (!changed_.wait(lock, stop, is_over))
      return absl::CancelledError("stopped while another thread prepared what the unit reads");
  }
  const auto slot = std::make_shared<Slot>(Slot{std::move(digests), scene, {}, nullptr});
  slots_.push_front(slot);
  lock.unlock();

  // Threads that wait must hear of it, whatever happens.
  Inputs inputs;
  using Result = absl::StatusOr<std::shared_ptr<const render::Prepared>>;
  const Result prepared = or_exhausted("preparing what the unit reads", [&]() -> Result {
    absl::StatusOr<Inputs> fetched = fetch(job_id, unit, stop);
    if (!fetched.ok()) return fetched.status();
    inputs = *std::move(fetched);
    return scene->scene->prepare(inputs.blob_contents);
  });

  lock.lock();
  if (prepared.ok()) {
    slot->inputs = std::move(inputs);
    slot->prepared = *prepared;
    if (slots_.size() > kKept && slots_.back()->prepared != nullptr) slots_.pop_back();
  } else {
    slots_.remove(slot);
  }
  changed_.notify_all();
  if (!prepared.ok()) return prepared.status();
  return whole(slot);
}

void PreparedStore::drop(const std::string& job_id) {
  const std::lock_guard lock{mutex_};
  const auto job = read_.extract(job_id);
  if (job.empty()) return;
  const auto is_read = [&](const std::string& digest) {
    return std::any_of(read_.begin(), read_.end(),
                       [&](const auto& other) { return other.second.contains(digest); });
  };
  for (const std::string& digest : job.mapped()) {
    if (is_read(digest)) continue;
    std::erase_if(slots_, [&](const auto& slot) {
      return slot->prepared != nullptr &&
             std::find(slot->digests.begin(), slot->digests.end(), digest) != slot->digests.end();
    });
    if (fetcher_ != nullptr) fetcher_->drop(digest);
  }
}

}  // namespace tessera::agent
