#include "agent/stores/scene_store.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "agent/stores/or_exhausted.h"
#include "wire/message_digest.h"

namespace tessera::agent {
namespace {

/// Two specs with the same key need the same RenderScene for each of their views.
std::string key_of(const v1::JobSpec& spec) {
  return absl::StrCat(spec.farm().isa(), " ",
                      wire::digest_of({&spec.content(), &spec.view(), &spec.samples()}));
}

}  // namespace

struct SceneStore::Slot {
  std::string key;
  std::uint32_t view = 0;
  std::string digest;
  std::optional<absl::StatusOr<std::shared_ptr<const LoadedScene>>> result;  // absent while loading
  bool loading = false;
  int waiting = 0;  // callers not yet stopped
  std::stop_source abandoned;
};

SceneStore::SceneStore(base::Clock& clock, Loader loader, std::size_t keep, std::size_t cap_bytes)
    : loader_(std::move(loader)), keep_(keep), cap_bytes_(cap_bytes), changed_(clock) {}

absl::StatusOr<std::shared_ptr<const LoadedScene>> SceneStore::get(const v1::JobSpec& spec,
                                                                   std::uint32_t view, std::stop_token stop) {
  while (true) {
    std::unique_lock lock{mutex_};
    const std::shared_ptr<Slot> slot = slot_for(spec, view);
    if (slot->result) return *slot->result;

    ++slot->waiting;
    lock.unlock();
    // Runs on whatever thread revokes the unit; the last caller to lose interest stops the load. No lock may
    // be held where this object begins or ends.
    std::stop_callback lost_interest{stop, [this, slot] {
                                       std::lock_guard guard{mutex_};
                                       if (--slot->waiting == 0) slot->abandoned.request_stop();
                                     }};
    absl::StatusOr<std::shared_ptr<const LoadedScene>> scene = load_or_wait(slot, spec, stop);
    // The load was stopped before this caller came, for want of others.
    const bool came_too_late = absl::IsCancelled(scene.status()) && slot->abandoned.stop_requested();
    if (!came_too_late || stop.stop_requested()) return scene;
  }
}

absl::StatusOr<std::shared_ptr<const LoadedScene>> SceneStore::load_or_wait(const std::shared_ptr<Slot>& slot,
                                                                            const v1::JobSpec& spec,
                                                                            std::stop_token stop) {
  std::unique_lock lock{mutex_};
  // Views are loaded one after the other: all but the first find there what they share.
  const auto is_turn = [&] {
    return slot->loading || std::ranges::none_of(slots_, [&](const auto& other) {
             return other->key == slot->key && other->loading && !other->result;
           });
  };
  if (!changed_.wait(lock, stop, is_turn) ||
      (slot->loading && !changed_.wait(lock, stop, [&] { return slot->result.has_value(); }))) {
    return absl::CancelledError("stopped while the scene was loading");
  }
  if (slot->loading) return *slot->result;
  slot->loading = true;
  lock.unlock();
  // Threads that wait here too must hear of it, whatever happens.
  absl::StatusOr<LoadedScene> loaded = or_exhausted(
      "loading the scene", [&] { return loader_(spec, slot->view, slot->abandoned.get_token()); });
  lock.lock();
  if (loaded.ok()) {
    slot->result = std::make_shared<const LoadedScene>(*std::move(loaded));
    forget_oldest();
  } else {
    slot->result = loaded.status();
    slots_.remove(slot);
  }
  changed_.notify_all();
  return *slot->result;
}

std::shared_ptr<SceneStore::Slot> SceneStore::slot_for(const v1::JobSpec& spec, std::uint32_t view) {
  const std::string key = key_of(spec);
  const auto found = std::find_if(slots_.begin(), slots_.end(),
                                  [&](const auto& slot) { return slot->view == view && slot->key == key; });
  if (found != slots_.end()) {
    slots_.splice(slots_.begin(), slots_, found);
    return slots_.front();
  }
  auto slot = std::make_shared<Slot>();
  slot->key = key;
  slot->view = view;
  slot->digest = spec.content().scene();
  slots_.push_front(slot);
  forget_oldest();
  return slot;
}

void SceneStore::forget_oldest() {
  // Units that still render hold their scene themselves. A scene that loads now is not the oldest for long.
  while (slots_.size() > 1 && slots_.back()->result && (scenes_held() > keep_ || bytes_held() > cap_bytes_)) {
    slots_.pop_back();
  }
}

std::size_t SceneStore::scenes_held() const {
  std::set<std::string_view> keys;
  for (const auto& slot : slots_) keys.insert(slot->key);
  return keys.size();
}

std::size_t SceneStore::bytes_held() const {
  std::map<const void*, std::size_t> bytes;  // by content: what scenes share counts once
  for (const auto& slot : slots_) {
    if (slot->result) bytes[(**slot->result)->content] = (**slot->result)->bytes;
  }
  std::size_t sum = 0;
  for (const auto& [content, size] : bytes) sum += size;
  return sum;
}

SceneStore::Held SceneStore::held() const {
  std::lock_guard lock{mutex_};
  const auto scenes =
      std::count_if(slots_.begin(), slots_.end(), [](const auto& slot) { return slot->result.has_value(); });
  return {static_cast<std::size_t>(scenes), bytes_held()};
}

std::vector<std::string> SceneStore::digests() const {
  std::lock_guard lock{mutex_};
  std::vector<std::string> digests;
  for (const auto& slot : slots_) {
    if (slot->result) digests.push_back(slot->digest);
  }
  return digests;
}

}  // namespace tessera::agent
