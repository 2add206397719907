#include "agent/stores/prepared_store.h"

#include <gtest/gtest.h>

#include <latch>
#include <thread>

#include "unit/agent/agent_fixture.h"

namespace tessera::agent {
namespace {

class PreparedStoreTest : public ::testing::Test {
 protected:
  PreparedStoreTest() {
    v1::BlobRef& input = *unit_.add_inputs();
    input.set_digest(coordinator_.add_blob("photons"));
    auto loaded = std::make_shared<LoadedScene>();
    loaded->scene = std::make_unique<FakeScene>(renderer_);
    scene_ = std::move(loaded);
  }

  FakeRenderer renderer_;
  FakeCoordinator coordinator_;
  GrpcLink link_{coordinator_.channel(), "the fake"};
  PreparedStore store_{base::machine_clock(), link_, nullptr};
  v1::WorkUnit unit_;
  std::shared_ptr<const LoadedScene> scene_;
};

TEST_F(PreparedStoreTest, PreparesOnceForAllWhoWait) {
  std::latch all_here{4};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      all_here.arrive_and_wait();
      EXPECT_TRUE(store_.get("job", unit_, scene_, {}).ok());
    });
  }
  threads.clear();
  EXPECT_EQ(renderer_.prepares, 1);
}

TEST_F(PreparedStoreTest, WhoeverWaitsGoesOnWhenMemoryRanOut) {
  // One of them runs out of memory; another prepares, and the rest have what it made.
  renderer_.failing_prepares = 1;
  std::latch all_here{4};
  std::atomic<int> failures{0};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      all_here.arrive_and_wait();
      const auto prepared = store_.get("job", unit_, scene_, {});
      if (prepared.ok()) return;
      ++failures;
      EXPECT_EQ(prepared.status().code(), absl::StatusCode::kResourceExhausted) << prepared.status();
    });
  }
  threads.clear();
  EXPECT_EQ(failures, 1);
  EXPECT_EQ(renderer_.prepares, 2);
}

}  // namespace
}  // namespace tessera::agent
