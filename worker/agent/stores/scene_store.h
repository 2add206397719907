// Scenes ready to render, each loaded once however many units need it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "base/clock.h"
#include "render/scene/load_scene.h"
#include "tessera/v1/job.pb.h"

namespace tessera::agent {

/// A loaded scene and what the loading cost.
struct LoadedScene {
  std::unique_ptr<render::RenderScene> scene;
  double load_seconds = 0;  // fetching blobs and building
  double build_seconds = 0;
  std::size_t bytes = 0;          // held
  const void* content = nullptr;  // equal for scenes that share those bytes
};

/// Thread-safe.
class SceneStore {
 public:
  /// Fetches and builds; gives up, with Cancelled, when `stop` is requested.
  using Loader = std::function<absl::StatusOr<LoadedScene>(const v1::JobSpec& spec, std::uint32_t view,
                                                           std::stop_token stop)>;

  /// Keeps the scenes used last: at most `keep`, of which all views count as one, and no more than
  /// `cap_bytes` beside the very last.
  SceneStore(base::Clock& clock, Loader loader, std::size_t keep, std::size_t cap_bytes = SIZE_MAX);

  /// The scene as `spec` wants it, in one of its views. The first caller loads it on its own thread, the
  /// others wait. A load whose callers have all been stopped is stopped too; whoever comes before it has
  /// ended takes its scene where it ends well all the same, and else loads anew: no scene is loaded twice at
  /// once, nor are two of its views. A failed load is not remembered: whoever comes next tries again.
  absl::StatusOr<std::shared_ptr<const LoadedScene>> get(const v1::JobSpec& spec, std::uint32_t view,
                                                         std::stop_token stop);

  struct Held {
    std::size_t scenes = 0;  // number of scenes; each view is one
    std::size_t bytes = 0;   // memory of the scenes; what they share counts once
  };
  Held held() const;

  /// Digests of the scenes held.
  std::vector<std::string> digests() const;

 private:
  struct Slot;
  std::shared_ptr<Slot> slot_for(const v1::JobSpec& spec, std::uint32_t view);
  absl::StatusOr<std::shared_ptr<const LoadedScene>> load_or_wait(const std::shared_ptr<Slot>& slot,
                                                                  const v1::JobSpec& spec,
                                                                  std::stop_token stop);
  void forget_oldest();
  std::size_t scenes_held() const;
  std::size_t bytes_held() const;

  const Loader loader_;
  const std::size_t keep_, cap_bytes_;
  mutable std::mutex mutex_;
  base::Condition changed_;
  std::list<std::shared_ptr<Slot>> slots_;  // the last used first
};

}  // namespace tessera::agent
