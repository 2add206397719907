#include "stress/input/input_judge.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <regex>
#include <sstream>
#include <stop_token>
#include <thread>

#include "absl/strings/str_cat.h"
#include "import/import.h"
#include "render/scene/load_scene.h"
#include "tessera/v1/job.pb.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"
#include "wire/limits.h"
#include "wire/resolve_settings.h"
#include "wire/scene_views.h"
#include "wire/settings.h"

namespace tessera::stress {
namespace {

// A sound case takes milliseconds; all of these are hangs.
constexpr std::chrono::seconds kPatience{20};

/// Whether an error of the renderer names an element of the scene or a setting: importers put file and line
/// into the names.
bool names_element(const std::string& message, const std::string& file) {
  static const std::regex kElement(
      R"((^|[^a-z])((shapes?|lights?|instances?|objects?|media|materials?|textures?)\[\d+\]|(shape|light|instance) \d+|(object|medium|material|texture|image|mesh|volume) '|(camera|rig|film|settings|animation)(:|\.)))");
  const auto names_setting = [&](const wire::SettingField& setting) {
    return message.starts_with(setting.name + " is ") || message.starts_with(setting.field->name() + " is ");
  };
  return message.find(absl::StrCat(file, ":")) != std::string::npos || std::regex_search(message, kElement) ||
         std::ranges::any_of(wire::settings(), names_setting);
}

absl::StatusOr<render::BlobBytes> bytes_of(const client::SceneBlob& blob) {
  if (blob.file.empty()) return render::BlobBytes{blob.bytes, nullptr};
  std::ifstream in(blob.file, std::ios::binary);
  if (!in) return absl::NotFoundError(blob.file);
  auto bytes =
      std::make_shared<std::string>(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  return render::BlobBytes{*bytes, bytes};
}

v1::JobSpec job_of(const v1::Scene& scene) {
  v1::JobSpec job;
  wire::resolve_settings(scene.settings(), job);
  // With noise, the least that goes with it.
  const std::uint32_t spp = job.samples().noise() != 0 ? wire::kLeastNoiseSamples : 2;
  job.mutable_samples()->set_spp(spp);
  job.mutable_cut()->set_samples_per_unit(spp);
  v1::JobSpec::View& view = *job.mutable_view();
  view.set_width(8);
  view.set_height(8);
  const wire::AlgorithmTraits* const algorithm = wire::find_algorithm(scene.settings().integrator());
  for (const v1::AOV aov : {v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH}) {
    if (algorithm != nullptr && algorithm->first_hit_aovs) view.add_aovs(aov);
  }
  // No phase but the pilot of noise is made here.
  if (algorithm != nullptr && algorithm->phases.empty()) wire::add_phases(job);
  return job;
}

}  // namespace

/// Ends the process when a case goes on for too long outside of what can be stopped, and says which.
class InputJudge::Watchdog {
 public:
  Watchdog() : thread_([this](std::stop_token stop) { run(stop); }) {}
  void begin(std::string what) {
    const std::lock_guard lock(mutex_);
    what_ = std::move(what);
    deadline_ = std::chrono::steady_clock::now() + 2 * kPatience;
  }

 private:
  void run(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, stop, std::chrono::milliseconds(200), [] { return false; }) &&
           !stop.stop_requested()) {
      if (what_.empty() || std::chrono::steady_clock::now() < deadline_) continue;
      std::fprintf(stderr, "no end of: %s\n", what_.c_str());
      std::abort();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string what_;
  std::chrono::steady_clock::time_point deadline_;
  std::jthread thread_;  // last: it reads all of the above
};

std::string Tally::to_string() const {
  return absl::StrCat(cases(), " cases: ", refused_by_importer, " refused by the importer, ",
                      refused_by_renderer, " by the renderer, ", rendered, " rendered, ",
                      with_dropped_samples, " of them with samples dropped");
}

InputJudge::InputJudge() : watchdog_(std::make_unique<Watchdog>()), isa_(render::supported_isas().front()) {}
InputJudge::~InputJudge() = default;

std::string InputJudge::judge_file(const std::filesystem::path& path, const std::filesystem::path& bad_file) {
  watchdog_->begin(path.string());
  const auto imported = client::import_scene(path, {.threads = 1, .defines = {}});
  const std::string name = (bad_file.empty() ? path : bad_file).filename().string();
  if (!imported.ok()) {
    ++tally_.refused_by_importer;
    const std::string message(imported.status().message());
    const bool located = bad_file.empty() ? std::regex_search(message, std::regex(name + R"(:\d+)"))
                                          : message.find(name) != std::string::npos;
    return located ? "" : absl::StrCat("an error that does not say where: ", message);
  }
  return render(imported->scene, imported->blobs, name);
}

std::string InputJudge::judge_scene(const v1::Scene& scene, const std::vector<client::SceneBlob>& blobs) {
  watchdog_->begin("a scene message");
  // The worker knows no rigs.
  v1::Scene resolved = scene;
  if (const absl::Status status = wire::resolve_rig(resolved); !status.ok()) {
    ++tally_.refused_by_renderer;
    return "";
  }
  return render(resolved, blobs, "no file");
}

std::string InputJudge::render(const v1::Scene& scene, const std::vector<client::SceneBlob>& blobs,
                               const std::string& file) {
  std::map<std::string, const client::SceneBlob*> by_digest;
  for (const client::SceneBlob& blob : blobs) by_digest[blob.ref.digest()] = &blob;
  const auto source = [&](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const auto it = by_digest.find(digest);
    return it == by_digest.end() ? absl::NotFoundError("no such blob") : bytes_of(*it->second);
  };
  const v1::JobSpec job = job_of(scene);
  const absl::Status sound = wire::check_settings(job);
  const auto loaded = sound.ok() ? render::load_scene(scene, job, source, {isa_, 1}) : sound;
  if (!loaded.ok()) {
    ++tally_.refused_by_renderer;
    const std::string message(loaded.status().message());
    return names_element(message, file)
               ? ""
               : absl::StrCat("an error that names no element of the scene: ", message);
  }
  ++tally_.rendered;
  std::stop_source stop;
  std::condition_variable_any done;
  std::mutex mutex;
  const std::jthread timer([&](std::stop_token ended) {
    std::unique_lock lock(mutex);
    if (!done.wait_for(lock, ended, kPatience, [] { return false; }) && !ended.stop_requested())
      stop.request_stop();
  });
  render::RenderStats stats;
  std::shared_ptr<const render::Prepared> prepared;
  if (job.cut().phases_size() > 0) {
    const auto pilot = (*loaded)->make_part({}, {}, stop.get_token(), stats);
    if (!pilot.ok()) return absl::StrCat("no pilot: ", std::string(pilot.status().message()));
    const std::string_view blobs_of_phases[] = {*pilot};
    auto made = (*loaded)->prepare(blobs_of_phases);
    if (!made.ok()) return absl::StrCat("no plan: ", std::string(made.status().message()));
    prepared = *std::move(made);
  }
  const std::uint32_t samples = job.samples().spp();
  const auto tile =
      (*loaded)->render_tile({0, 0, 8, 8, 0, samples, 0, prepared.get()}, stop.get_token(), stats);
  if (!tile.ok()) return absl::StrCat("no picture: ", std::string(tile.status().message()));
  tally_.with_dropped_samples += stats.dropped_samples > 0;
  const auto bad =
      std::find_if(tile->values.begin(), tile->values.end(), [](float x) { return !std::isfinite(x); });
  if (bad == tile->values.end()) return "";
  return absl::StrCat("a pixel of channel ", (bad - tile->values.begin()) / 64, " is ", *bad);
}

}  // namespace tessera::stress
