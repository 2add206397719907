// Cases that need no farm of their own; the rest is in tests/scenario.
#include "scheduler/scheduler.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

WorkerInfo worker_called(const std::string& id) {
  return {.id = id,
          .name = "",
          .build = "",
          .isa = "avx2",
          .supported_isas = {"avx2"},
          .threads = 1,
          .host = id,
          .tags = {}};
}

TEST(Scheduler, AUnitThatIsGrantedAnewToItsHolderIsNotRevoked) {
  v1::JobSpec spec;
  spec.mutable_view()->set_width(8);
  spec.mutable_view()->set_height(8);
  spec.mutable_cut()->mutable_crop()->set_x1(8);
  spec.mutable_cut()->mutable_crop()->set_y1(8);
  spec.mutable_cut()->set_tile_size(8);
  spec.mutable_cut()->set_samples_per_unit(16);
  spec.mutable_samples()->set_spp(16);
  spec.mutable_content()->set_scene(std::string(64, 'a'));
  spec.mutable_farm()->add_blobs()->set_digest(spec.content().scene());
  const auto plan = std::make_shared<const WorkPlan>(WorkPlan::make(spec).value());

  // After a restart, the worker asks for units before it has said what it holds from the coordinator of
  // before.
  v1::LeaseToken held;
  for (const std::uint64_t epoch : {1, 2}) {
    Scheduler scheduler({.epoch = epoch});
    ASSERT_TRUE(scheduler
                    .add_job({.id = "job",
                              .plan = plan,
                              .scene_digest = "s",
                              .isa = "avx2",
                              .user = "",
                              .required_tags = {}})
                    .ok());
    ASSERT_TRUE(scheduler.register_worker(worker_called("w"), Time{0}).ok());
    ASSERT_TRUE(scheduler.register_worker(worker_called("other"), Time{0}).ok());
    const auto granted = scheduler.lease({.worker = "w", .max_units = 1, .loaded_scenes = {}}, Time{0});
    ASSERT_EQ(granted->leases.size(), 1u);
    if (epoch == 1) {
      held = granted->leases[0].token();
      continue;
    }
    EXPECT_TRUE(scheduler.heartbeat("w", {held}, Time{5000})->revoked.empty())
        << "it goes on with what it holds";
    EXPECT_EQ(scheduler.heartbeat("other", {held}, Time{5000})->revoked.size(), 1u);
    scheduler.advance(Time{9000});
    EXPECT_EQ(scheduler.leases_out(), 1u) << "it was heard of";
    EXPECT_TRUE(scheduler.complete("w", held, {.fingerprint = 1, .cost = Time{1}}, Time{9000}).ok());
    EXPECT_EQ(scheduler.job("job")->state, v1::DONE);
  }
}

TEST(Scheduler, LargeFarmsAreHeardOfLessOftenAndAreMorePatient) {
  Scheduler scheduler({.heartbeat_interval = Time{1000}, .lease_timeout = Time{8000}});
  const auto grow = [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      EXPECT_TRUE(scheduler.register_worker(worker_called(absl::StrCat(i)), Time{0}).ok());
    }
  };
  grow(0, 2000);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{1000});
  EXPECT_TRUE(scheduler.advance(Time{7999}).lost_workers.empty());
  grow(2000, 6000);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{3000});
  EXPECT_TRUE(scheduler.advance(Time{7999}).lost_workers.empty());
  grow(6000, 20'000);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{5000})
      << "and no less often, or dead workers are noticed too late";
  EXPECT_TRUE(scheduler.advance(Time{12'499}).lost_workers.empty());
  EXPECT_EQ(scheduler.advance(Time{12'500}).lost_workers.size(), 20'000u);
  EXPECT_EQ(scheduler.heartbeat_interval(), Time{1000});
}

}  // namespace
}  // namespace tessera::server
