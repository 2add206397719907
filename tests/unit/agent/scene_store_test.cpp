#include "agent/stores/scene_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <latch>
#include <thread>
#include <vector>

namespace tessera::agent {
namespace {

v1::JobSpec spec(const std::string& digest, std::uint32_t width = 8) {
  v1::JobSpec spec;
  spec.mutable_content()->set_scene(digest);
  spec.mutable_view()->set_width(width);
  return spec;
}

TEST(SceneStore, WhoeverWaitsHearsThatMemoryRanOut) {
  int loads = 0;
  SceneStore store{base::machine_clock(),
                   [&](const v1::JobSpec&, std::uint32_t, std::stop_token) -> absl::StatusOr<LoadedScene> {
                     if (++loads == 1) throw std::bad_alloc();
                     return LoadedScene{};
                   },
                   2};
  EXPECT_EQ(store.get(spec("a"), 0, {}).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(store.get(spec("a"), 0, {}).ok()) << "the failure is not kept";
}

TEST(SceneStore, LoadsOnceForAllWhoWait) {
  std::atomic<int> loads{0};
  std::latch all_asked{5};
  SceneStore store{base::machine_clock(),
                   [&](const v1::JobSpec&, std::uint32_t, std::stop_token) -> absl::StatusOr<LoadedScene> {
                     ++loads;
                     all_asked.wait();
                     return LoadedScene{};
                   },
                   2};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      all_asked.count_down();
      EXPECT_TRUE(store.get(spec("a"), 0, {}).ok());
    });
  }
  all_asked.count_down();
  threads.clear();
  EXPECT_EQ(loads, 1);
}

TEST(SceneStore, KeepsTheScenesUsedLast) {
  int loads = 0;
  SceneStore store{base::machine_clock(),
                   [&](const v1::JobSpec&, std::uint32_t, std::stop_token) -> absl::StatusOr<LoadedScene> {
                     ++loads;
                     return LoadedScene{};
                   },
                   2};
  for (const char* digest : {"a", "b", "a", "c"}) ASSERT_TRUE(store.get(spec(digest), 0, {}).ok());
  EXPECT_EQ(loads, 3);
  EXPECT_EQ(store.digests(), (std::vector<std::string>{"c", "a"}));
}

TEST(SceneStore, KeepsNoMoreThanItsMemoryBesideTheLast) {
  const int contents[3] = {};
  SceneStore store{
      base::machine_clock(),
      [&](const v1::JobSpec& job, std::uint32_t, std::stop_token) -> absl::StatusOr<LoadedScene> {
        LoadedScene loaded;
        loaded.bytes = job.content().scene() == "huge" ? 1000 : 40;
        loaded.content = job.content().scene() == "a twin" ? &contents[0]
                         : loaded.bytes > 40               ? &contents[2]
                                                           : &contents[job.content().scene()[0] - 'a'];
        return loaded;
      },
      10, 100};
  for (const char* digest : {"a", "b", "a twin"}) ASSERT_TRUE(store.get(spec(digest), 0, {}).ok());
  EXPECT_EQ(store.digests(), (std::vector<std::string>{"a twin", "b", "a"})) << "two share their 40 bytes";
  ASSERT_TRUE(store.get(spec("huge"), 0, {}).ok());
  EXPECT_EQ(store.digests(), (std::vector<std::string>{"huge"}));
  ASSERT_TRUE(store.get(spec("b"), 0, {}).ok());
  EXPECT_EQ(store.digests(), (std::vector<std::string>{"b"}));
}

TEST(SceneStore, NeitherHowTheWorkIsCutNorWhoseItIsMakesAnotherScene) {
  int loads = 0;
  SceneStore store{base::machine_clock(),
                   [&](const v1::JobSpec&, std::uint32_t, std::stop_token) -> absl::StatusOr<LoadedScene> {
                     ++loads;
                     return LoadedScene{};
                   },
                   4};
  v1::JobSpec first = spec("a");
  first.mutable_cut()->set_tile_size(8);
  v1::JobSpec second = spec("a");
  second.mutable_cut()->set_tile_size(64);
  second.mutable_cut()->mutable_crop()->set_x1(100);
  second.mutable_farm()->set_user("bob");
  second.mutable_farm()->add_blobs()->set_size_bytes(7);
  second.mutable_farm()->add_required_tags("gpu");
  second.mutable_farm()->set_max_workers(3);
  second.mutable_farm()->set_bits(v1::BITS_ANY);
  second.mutable_cut()->add_phases()->set_parts(4);
  ASSERT_TRUE(store.get(first, 0, {}).ok());
  ASSERT_TRUE(store.get(second, 0, {}).ok());
  EXPECT_EQ(loads, 1);
  ASSERT_TRUE(store.get(spec("a", 16), 0, {}).ok());
  EXPECT_EQ(loads, 2);
}

TEST(SceneStore, ViewsAreLoadedOneAfterTheOtherAndCountAsOneScene) {
  std::atomic<int> at_once = 0, most = 0;
  SceneStore store{
      base::machine_clock(),
      [&](const v1::JobSpec&, std::uint32_t view, std::stop_token) -> absl::StatusOr<LoadedScene> {
        most = std::max<int>(most, ++at_once);
        std::this_thread::yield();
        --at_once;
        return LoadedScene{.scene = nullptr, .load_seconds = double(view)};
      },
      1};
  {
    std::vector<std::jthread> callers;
    for (std::uint32_t view = 0; view < 8; ++view) {
      callers.emplace_back([&store, view] {
        const auto loaded = store.get(spec("a"), view, {});
        ASSERT_TRUE(loaded.ok());
        EXPECT_EQ((*loaded)->load_seconds, view);
      });
    }
  }
  EXPECT_EQ(most, 1);
  EXPECT_EQ(store.held().scenes, 8u);
  ASSERT_TRUE(store.get(spec("b"), 0, {}).ok());
  EXPECT_EQ(store.held().scenes, 1u);
}

TEST(SceneStore, AFailedLoadIsTriedAgain) {
  int loads = 0;
  SceneStore store{base::machine_clock(),
                   [&](const v1::JobSpec&, std::uint32_t, std::stop_token) -> absl::StatusOr<LoadedScene> {
                     if (++loads == 1) return absl::UnavailableError("no");
                     return LoadedScene{};
                   },
                   2};
  EXPECT_FALSE(store.get(spec("a"), 0, {}).ok());
  EXPECT_TRUE(store.get(spec("a"), 0, {}).ok());
}

TEST(SceneStore, ALoadThatNobodyWantsAnyMoreIsStopped) {
  std::latch loading{1};
  SceneStore store{
      base::machine_clock(),
      [&](const v1::JobSpec&, std::uint32_t, std::stop_token stop) -> absl::StatusOr<LoadedScene> {
        loading.count_down();
        while (!stop.stop_requested()) std::this_thread::yield();
        return absl::CancelledError("stopped");
      },
      2};
  std::stop_source first, second;
  std::jthread a{[&] { EXPECT_FALSE(store.get(spec("a"), 0, first.get_token()).ok()); }};
  loading.wait();
  std::jthread b{[&] { EXPECT_FALSE(store.get(spec("a"), 0, second.get_token()).ok()); }};
  first.request_stop();
  second.request_stop();
}

/// A load whose only caller has lost interest, and a second caller who comes before it ends, as it will by
/// `end`: the number of loads, and what the second caller gets.
std::pair<int, absl::Status> come_after_the_last(const std::function<absl::Status()>& end) {
  std::atomic<int> loads{0};
  std::latch loading{1}, second_comes{1};
  SceneStore store{
      base::machine_clock(),
      [&](const v1::JobSpec&, std::uint32_t, std::stop_token stop) -> absl::StatusOr<LoadedScene> {
        if (++loads > 1) return LoadedScene{};
        loading.count_down();
        while (!stop.stop_requested()) std::this_thread::yield();
        second_comes.wait();
        if (absl::Status status = end(); !status.ok()) return status;
        return LoadedScene{};
      },
      2};
  std::stop_source first;
  std::jthread a{[&] { store.get(spec("a"), 0, first.get_token()).IgnoreError(); }};
  loading.wait();
  first.request_stop();
  absl::Status second;
  std::jthread b{[&] { second = store.get(spec("a"), 0, {}).status(); }};
  second_comes.count_down();
  b.join();
  return {loads, second};
}

TEST(SceneStore, AStoppedLoadThatEndsWellServesWhoeverComesNext) {
  const auto [loads, second] = come_after_the_last([] { return absl::OkStatus(); });
  EXPECT_TRUE(second.ok()) << second;
  EXPECT_EQ(loads, 1);
}

TEST(SceneStore, AStoppedLoadIsDoneAnewForWhoeverComesNext) {
  const auto [loads, second] = come_after_the_last([] { return absl::CancelledError("stopped"); });
  EXPECT_TRUE(second.ok()) << second;
  EXPECT_EQ(loads, 2);
}

}  // namespace
}  // namespace tessera::agent
