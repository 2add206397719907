// Work that threads share, also where a piece of it fails.
#include "render/textbook/preview/shared_work.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <new>
#include <set>
#include <thread>
#include <vector>

#include "unit/render/preview/preview_scene.h"

namespace tessera::render::TESSERA_ISA::preview_test {
namespace {

/// Rays that nobody asks for.
class NoRays final : public RayQuery {
 public:
  void nearest(const RayArrays&, int, bool, const HitArrays&) const override {}
  void occluded(const RayArrays&, int, float*) const override {}
};

TEST(SharedWork, DoesStagesInTurnAndEachPieceOnce) {
  std::atomic<int> first{0}, second{0};
  SharedWork work({{100, [&](std::size_t, const RayQuery&) { ++first; }},
                   {0, [](std::size_t, const RayQuery&) { ADD_FAILURE() << "there is no piece"; }},
                   {50, [&](std::size_t, const RayQuery&) {
                      EXPECT_EQ(first, 100);
                      ++second;
                    }}});
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] { EXPECT_TRUE(work.help(NoRays(), {})); });
  }
  threads.clear();
  EXPECT_EQ(first, 100);
  EXPECT_EQ(second, 50);
}

TEST(SharedWork, APieceThatFailsIsThereForTheNext) {
  std::multiset<std::size_t> done;
  int failures = 2;
  SharedWork work({{3, [&](std::size_t piece, const RayQuery&) {
                      if (piece == 1 && failures-- > 0) throw std::bad_alloc();
                      done.insert(piece);
                    }}});
  EXPECT_THROW(work.help(NoRays(), {}), std::bad_alloc);
  EXPECT_THROW(work.help(NoRays(), {}), std::bad_alloc);
  EXPECT_TRUE(work.help(NoRays(), {}));
  EXPECT_EQ(done, (std::multiset<std::size_t>{0, 1, 2}));
}

TEST(SharedWork, WhoeverWaitsTakesOverAPieceThatFails) {
  std::latch both_here{2};
  std::atomic<int> tries{0}, failures{0};
  SharedWork work({{1, [&](std::size_t, const RayQuery&) {
                      if (++tries > 1) return;
                      both_here.arrive_and_wait();
                      throw std::bad_alloc();
                    }}});
  const auto help = [&](bool arrives) {
    if (arrives) both_here.count_down();
    try {
      EXPECT_TRUE(work.help(NoRays(), {}));
    } catch (const std::bad_alloc&) {
      ++failures;
    }
  };
  std::jthread one([&] { help(false); });
  while (tries == 0) std::this_thread::yield();
  std::jthread other([&] { help(true); });
  one.join();
  other.join();
  EXPECT_EQ(tries, 2);
  EXPECT_EQ(failures, 1);
}

TEST(Bins, KeepFewEntriesOfClustersThatCoverTheFilm) {
  // Triangles about the camera: each cluster crosses its plane, and may be anywhere on the film.
  const auto content = build_kernel_scene(scene_text(), 100, [](SceneArrays& a) {
    for (int i = 0; i < 20; ++i)
      add_rectangle(a, {-9, -1.0f - static_cast<float>(i), -9}, {18, 0, 0}, {0, 0.5f, 18});
  });
  ASSERT_NE(content, nullptr);
  Clusters clusters(content->arrays.shapes);
  clusters.fill(0, clusters.size());
  Projection projection = projection_of(content->tables.sensor, 1e-4f, 1);
  projection.width = 4096, projection.height = 2100;  // 128 x 66 bins
  Bins bins(clusters, content->arrays.shapes, projection);
  const std::vector<std::uint8_t> seen(content->arrays.shapes.shapes.size(), 1);
  // A second time, as if memory had run out for the piece.
  for (int i = 0; i < 2; ++i) bins.find(0, seen);
  bins.sort();
  EXPECT_LE(bins.entries(), 4 * clusters.drawn());
  for (const auto& [column, row] : {std::pair(0, 0), {127, 65}, {64, 30}}) {
    Bins::Walk walk = bins.walk(column, row);
    std::set<std::uint32_t> draws;
    while (const BinEntry* const entry = walk.next()) {
      EXPECT_TRUE(draws.insert(entry->draw).second);
      EXPECT_EQ(entry->draw, *draws.rbegin()) << "ties by the scene's order";
    }
    EXPECT_EQ(draws.size(), 20u) << column << ' ' << row;
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::preview_test
