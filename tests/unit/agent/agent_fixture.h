// An agent with a renderer that needs no scene, and a coordinator that misbehaves.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <new>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "agent/agent.h"
#include "agent/link/grpc_link.h"
#include "support/process/temp_dir.h"
#include "tessera/v1/scene.pb.h"
#include "unit/agent/fake_coordinator.h"
#include "wire/aov_channels.h"
#include "wire/tile_result.h"

namespace tessera::agent {

/// Behaviour of the fake scenes of one test, and counts of their calls.
struct FakeRenderer {
  std::atomic<int> loads{0};
  std::atomic<int> renders{0};
  std::set<std::uint32_t> hanging_tiles;  // x0 of tiles that never finish by themselves
  std::atomic<int> hanging{0};
  std::atomic<bool> gate_open{false};  // lets hanging tiles finish
  absl::Status load_error;
  bool needs_blobs = true;  // loading asks for all of the job
  std::atomic<int> prepares{0};
  int failing_prepares = 0;  // the first of them run out of memory
};

class FakeScene final : public render::RenderScene {
 public:
  explicit FakeScene(FakeRenderer& renderer) : renderer_(renderer) {}

  absl::StatusOr<wire::TileResult> render_tile(const render::TileRequest& tile, std::stop_token stop,
                                               render::RenderStats& stats) const override {
    if (renderer_.hanging_tiles.contains(tile.x0)) {
      ++renderer_.hanging;
      while (!renderer_.gate_open && !stop.stop_requested()) std::this_thread::yield();
      if (stop.stop_requested()) return absl::CancelledError("stopped");
    }
    ++renderer_.renders;
    wire::TileResult result{
        tile.x0, tile.y0, tile.x1, tile.y1, tile.sample_begin, tile.sample_end, wire::channels_for_aovs({}),
        {},      {}};
    result.counts.assign(result.pixel_count(), tile.sample_end - tile.sample_begin);
    result.values.assign(result.pixel_count() * result.channels.size(), static_cast<float>(tile.x0));
    stats.samples += result.pixel_count();
    return result;
  }
  absl::StatusOr<std::shared_ptr<const render::Prepared>> prepare(
      std::span<const std::string_view>) const override {
    if (++renderer_.prepares <= renderer_.failing_prepares) throw std::bad_alloc();
    return std::make_shared<const render::Prepared>();
  }
  absl::StatusOr<std::string> make_part(const render::PartRequest&, const render::FilmRect&, std::stop_token,
                                        render::RenderStats&) const override {
    return "";
  }
  absl::StatusOr<std::string> merge(std::uint32_t, std::span<const std::string_view>) const override {
    return "";
  }
  const std::vector<std::string>& material_names() const override { return warnings_; }
  absl::StatusOr<Ceiling> measure_ceiling(const render::TileRequest&, std::stop_token) const override {
    return Ceiling{};
  }
  const std::vector<std::string>& warnings() const override { return warnings_; }
  std::size_t memory_bytes() const override { return 1; }

 private:
  FakeRenderer& renderer_;
  std::vector<std::string> warnings_{"fog is left out"};
};

class AgentTest : public ::testing::Test {
 protected:
  v1::JobSpec spec_for_scene(int corrupt_downloads = 0, std::size_t break_after = 0) {
    v1::Scene scene;
    scene.set_name(std::string(5000, 'x'));  // several chunks of the fake's download
    v1::JobSpec spec;
    spec.mutable_content()->set_scene(
        coordinator_.add_blob(scene.SerializeAsString(), corrupt_downloads, break_after));
    return spec;
  }

  void start(int threads, std::chrono::milliseconds grace = std::chrono::seconds{10},
             std::chrono::milliseconds unit_limit = {}) {
    AgentOptions options;
    options.name = "test";
    options.threads = threads;
    options.isas = {"avx2"};
    options.cache_dir = cache_.path();
    options.grace = grace;
    options.unit_limit = unit_limit;
    options.recent_log = [](const std::string& job) { return std::vector{"the last of " + job}; };
    options.load_scene =
        [this](const v1::Scene& scene, const v1::JobSpec& job, const render::BlobSource& blobs,
               const render::LoadOptions&) -> absl::StatusOr<std::unique_ptr<render::RenderScene>> {
      ++renderer_.loads;
      if (!renderer_.load_error.ok()) return renderer_.load_error;
      for (const v1::BlobRef& blob : job.farm().blobs()) {
        if (!renderer_.needs_blobs) break;
        if (const auto bytes = blobs(blob.digest()); !bytes.ok()) return bytes.status();
      }
      EXPECT_EQ(scene.name().size(), 5000);
      return std::make_unique<FakeScene>(renderer_);
    };
    auto agent =
        Agent::create(std::make_unique<GrpcLink>(coordinator_.channel(), "the fake"), std::move(options));
    ASSERT_TRUE(agent.ok()) << agent.status();
    agent_ = *std::move(agent);
    runner_ = std::jthread{[this](std::stop_token stop) { status_ = agent_->run(stop); }};
  }

  absl::Status stop_and_join() {
    runner_.request_stop();
    runner_.join();
    return status_;
  }

  /// Waits until `count` tiles hang; the test's own timeout is the limit.
  void wait_for_hanging(int count) {
    while (renderer_.hanging < count) std::this_thread::yield();
  }

  support::TempDir cache_;
  FakeRenderer renderer_;
  FakeCoordinator coordinator_;
  std::unique_ptr<Agent> agent_;
  absl::Status status_;
  std::jthread runner_;
};

}  // namespace tessera::agent
