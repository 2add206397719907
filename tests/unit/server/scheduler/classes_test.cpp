// Arithmetic classes where a scenario cannot show them: journals from before there were any.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "scheduler/class_history.h"
#include "scheduler/class_tally.h"
#include "scheduler/scheduler.h"

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

WorkerInfo worker_of(const std::string& id, const std::vector<std::string>& classes,
                     std::uint32_t threads = 1) {
  return {.id = id,
          .name = id,
          .build = "",
          .isa = "avx2",
          .supported_isas = {"avx2"},
          .threads = threads,
          .host = id,
          .tags = {},
          .classes = classes};
}

std::shared_ptr<const WorkPlan> row_of(std::uint32_t tiles) {
  v1::JobSpec spec;
  spec.mutable_view()->set_width(8 * tiles);
  spec.mutable_view()->set_height(8);
  spec.mutable_cut()->mutable_crop()->set_x1(8 * tiles);
  spec.mutable_cut()->mutable_crop()->set_y1(8);
  spec.mutable_cut()->set_tile_size(8);
  spec.mutable_cut()->set_samples_per_unit(16);
  spec.mutable_samples()->set_spp(16);
  spec.mutable_content()->set_scene(std::string(64, 'a'));
  spec.mutable_farm()->add_blobs()->set_digest(spec.content().scene());
  return std::make_shared<const WorkPlan>(WorkPlan::make(spec).value());
}

/// A job with a result from before protocol 2: bound to an ISA then, and nobody knows to which class.
void restore_old_job(Scheduler& scheduler, const std::string& bound = "avx2") {
  ASSERT_TRUE(scheduler
                  .add_job({.id = "job",
                            .plan = row_of(3),
                            .scene_digest = "s",
                            .isa = "",
                            .user = "",
                            .required_tags = {},
                            .bound_class = bound})
                  .ok());
  const AcceptedResult result{
      .fingerprint = 1, .sequence = 1, .host = scheduler.number_of_host("old"), .units = {}};
  ASSERT_TRUE(scheduler.restore_done("job", result).ok());
  ASSERT_TRUE(scheduler.restored("job").ok());
}

TEST(Classes, AJobOfAnOldJournalGoesOnInOneClassOfItsIsa) {
  Scheduler scheduler({.audit_one_in = 1});
  restore_old_job(scheduler);
  EXPECT_EQ(scheduler.job("job")->isa, "avx2");
  ASSERT_TRUE(scheduler.register_worker(worker_of("one", {"avx512/e/a", "avx2/e/a"}, 1), Time{0}).ok());
  ASSERT_TRUE(scheduler.register_worker(worker_of("two", {"avx2/e/b"}, 2), Time{0}).ok());
  EXPECT_THAT(scheduler.lease({.worker = "one", .max_units = 1, .loaded_scenes = {}}, Time{0})->leases,
              IsEmpty());
  const auto granted = scheduler.lease({.worker = "two", .max_units = 1, .loaded_scenes = {}}, Time{0});
  ASSERT_EQ(granted->leases.size(), 1u) << "and no second opinion on a result of another class, maybe";
  EXPECT_EQ(granted->leases[0].token().unit_index(), 1u);
  EXPECT_THAT(scheduler.job("job")->classes, ElementsAre("avx2/e/b", "avx2"));
  EXPECT_EQ(scheduler.isa_for("two", "job"), "avx2");

  // The old result's class is journaled with the new bound.
  Scheduler next({.audit_one_in = 1, .epoch = 2});
  restore_old_job(next, "avx2/e/b");
  EXPECT_THAT(next.job("job")->classes, ElementsAre("avx2/e/b"));
  for (const FarmEvent& event : scheduler.take_events()) {
    if (event.kind != FarmEvent::Kind::kClassNoted) continue;
    EXPECT_TRUE(next.restore(event).ok());
  }
  EXPECT_THAT(next.job("job")->classes, ElementsAre("avx2/e/b", "avx2"));
}

TEST(Classes, OfOneHostMayChange) {
  ClassHistory history("avx2/e/a");
  EXPECT_FALSE(history.note("h", 1, "avx2/e/a"));
  EXPECT_TRUE(history.note("h", 5, "avx2/e/b"));
  EXPECT_FALSE(history.note("h", 7, "avx2/e/b"));
  EXPECT_TRUE(history.note("h", 9, "avx512/e/a"));
  EXPECT_EQ(history.of("h", 4), "avx2/e/a");
  EXPECT_EQ(history.of("h", 8), "avx2/e/b");
  EXPECT_EQ(history.of("h", 100), "avx512/e/a");
  EXPECT_EQ(history.of("other", 8), "avx2/e/a");
  EXPECT_THAT(history.all(), ElementsAre("avx2/e/a", "avx2/e/b", "avx512/e/a"));
  EXPECT_EQ(isas_of(history.all()), "avx512+avx2");
}

TEST(Classes, OfEquallyManyThreadsTheOneIsTakenThatItsWorkersLikeBest) {
  ClassTally class_tally;
  const std::vector<std::string> tags;
  EXPECT_EQ(class_tally.best({.isa = "", .tags = tags}), "");
  const WorkerInfo both = worker_of("both", {"avx512/e/a", "avx2/e/a"}, 8);
  class_tally.add(both, both.threads);
  class_tally.add(both, both.threads);
  EXPECT_EQ(class_tally.best({.isa = "", .tags = tags}), "avx512/e/a");
  EXPECT_EQ(class_tally.best({.isa = "avx2", .tags = tags}), "avx2/e/a");
  const WorkerInfo old = worker_of("old", {"avx2/e/a"}, 1);
  class_tally.add(old, old.threads);
  EXPECT_EQ(class_tally.best({.isa = "", .tags = tags}), "avx2/e/a");
  EXPECT_EQ(class_tally.best({.isa = "", .tags = tags, .max_workers = 2}), "avx2/e/a")
      << "as long as nobody is confirmed, it is identities that count, however few workers are needed";
  class_tally.remove(old, old.threads);
  EXPECT_EQ(class_tally.best({.isa = "", .tags = tags}), "avx512/e/a");
}

}  // namespace
}  // namespace tessera::server
