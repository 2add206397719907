#include "scheduler/phase_plan.h"

#include <gmock/gmock.h>

#include <set>

#include "scheduler/work_plan.h"
#include "support/phased_job.h"
#include "unit/server/requests.h"

namespace tessera::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

WorkPlan plan_of(const std::vector<std::uint32_t>& parts) {
  v1::JobSpec spec = square_spec("scene", 32, 4);
  test::add_test_phases(spec, parts);
  return WorkPlan::make(spec).value();
}

TEST(PhasePlan, AJobWithoutPhasesIsItsPicture) {
  const WorkPlan plan = WorkPlan::make(square_spec("scene", 32, 4)).value();
  EXPECT_EQ(plan.phases().unit_count(), 0u);
  EXPECT_EQ(plan.unit_count(), 16u);
  EXPECT_TRUE(plan.is_of_picture(0));
  EXPECT_THAT(plan.phases().inputs(0), IsEmpty());
  EXPECT_EQ(plan.step_end(0), 16u);
}

TEST(PhasePlan, OnlyThePicturesUnitsBeginATile) {
  const WorkPlan plan = plan_of({7, 1});
  for (std::uint32_t unit = 0; unit < plan.unit_count(); ++unit)
    EXPECT_EQ(plan.begins_tile(unit), unit >= 12 && unit < 16) << unit;
}

TEST(PhasePlan, PartsAreMergedThreeAtATimeUntilOneIsLeft) {
  // 7 parts (0 to 6), 3 merges (7, 8, 9), 1 (10); one part (11); the picture.
  const WorkPlan plan = plan_of({7, 1});
  const PhasePlan& phases = plan.phases();
  EXPECT_EQ(phases.unit_count(), 12u);
  EXPECT_EQ(plan.unit_count(), 12u + 16u);
  EXPECT_THAT(phases.roots(), ElementsAre(10, 11));
  EXPECT_EQ(plan.step_end(0), 7u);
  EXPECT_EQ(plan.step_end(7), 10u);
  EXPECT_EQ(plan.step_end(10), 11u);
  EXPECT_EQ(plan.step_end(11), 12u);
  EXPECT_EQ(plan.step_end(12), 28u);
  EXPECT_THAT(phases.inputs(3), IsEmpty());
  EXPECT_THAT(phases.inputs(8), ElementsAre(3, 4, 5));
  EXPECT_THAT(phases.inputs(9), ElementsAre(6));
  EXPECT_THAT(phases.inputs(10), ElementsAre(7, 8, 9));
  EXPECT_THAT(phases.inputs(11), ElementsAre(10)) << "later phases read earlier ones";
  EXPECT_THAT(phases.inputs(12), ElementsAre(10, 11));
  EXPECT_EQ(phases.reader(4), 8u);
  EXPECT_EQ(phases.reader(8), 10u);
  EXPECT_EQ(phases.reader(10), std::nullopt);
  EXPECT_EQ(phases.phase_end(3), 11u);
  EXPECT_EQ(phases.phase_end(10), 11u);
  EXPECT_EQ(phases.phase_end(11), 12u);

  EXPECT_EQ(plan.unit({.first = 4}).part().part(), 4u);
  EXPECT_EQ(plan.unit({.first = 8}).merge().level(), 1u);
  EXPECT_EQ(plan.unit({.first = 8}).merge().index(), 1u);
  EXPECT_EQ(plan.unit({.first = 11}).part().phase(), 1u);
  EXPECT_EQ(plan.unit({.first = 12}).tile().samples().begin(), 0u);
  EXPECT_EQ(plan.run(12, 1)->step, 4u);
  EXPECT_EQ(plan.run(4, 2), std::nullopt) << "only units of the picture go together";
  EXPECT_EQ(plan.longest_run(20).count, 2u);
}

TEST(PhasePlan, SourcesAreAllThatIsInWhatAUnitReads) {
  // 7 parts (0 to 6), 3 merges (7, 8, 9), 1 (10); 2 parts (11, 12), 1 merge (13); the picture.
  const WorkPlan plan = plan_of({7, 2});
  const PhasePlan& phases = plan.phases();
  EXPECT_THAT(phases.sources(3), IsEmpty());
  EXPECT_THAT(phases.sources(8), ElementsAre(3, 4, 5));
  EXPECT_THAT(phases.sources(10), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(phases.sources(12), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_THAT(phases.sources(13), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12));
  EXPECT_EQ(phases.sources(14).size(), 14u);
}

TEST(PhasePlan, EveryUnitButTheRootsIsReadOnceWithinItsPhase) {
  for (const std::uint32_t parts : {1u, 2u, 3u, 4u, 9u, 10u, 27u, 28u, 1000u}) {
    const WorkPlan plan = plan_of({parts, 5});
    const PhasePlan& phases = plan.phases();
    std::multiset<std::uint32_t> read;
    for (std::uint32_t unit = 0; unit < phases.unit_count(); ++unit) {
      for (const std::uint32_t input : phases.inputs(unit)) {
        EXPECT_LT(input, phases.step_begin(unit));
        if (unit >= phases.phase_end(input)) continue;
        read.insert(input);
        EXPECT_EQ(phases.reader(input), unit);
      }
    }
    EXPECT_EQ(read.size(), phases.unit_count() - 2);
    EXPECT_EQ(std::set(read.begin(), read.end()).size(), read.size());
  }
}

TEST(PhasePlan, PhasesThatAreUnsoundAreRefusedByName) {
  const auto message = [](const std::function<void(v1::JobSpec&)>& change) {
    v1::JobSpec spec = square_spec("scene", 32);
    test::add_test_phases(spec, {4, 4});
    change(spec);
    return std::string(WorkPlan::make(spec).status().message());
  };
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->mutable_phases(0)->set_parts(0); }),
              HasSubstr("has 0 parts"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->mutable_phases(1)->set_merge_width(1); }),
              HasSubstr("phase \"second\""));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->mutable_phases(1)->set_parts(1u << 31); }),
              HasSubstr("merge_width 3; 1 to 1048576"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->mutable_phases(0)->set_name("other"); }),
              HasSubstr("has other phases than the job: first, second"));
  EXPECT_THAT(
      message([](v1::JobSpec& s) { s.mutable_content()->mutable_algorithms()->set_integrator("path"); }),
      HasSubstr("has other phases"));
}

}  // namespace
}  // namespace tessera::server
