// Phases, end to end: real processes, and an algorithm that is not Tessera's own.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "image/exr.h"
#include "integration/phases/phases_job.h"

namespace tessera::integration {
namespace {

/// The part of the film that shows each brightness, of that which shows anything.
std::map<float, double> parts_of_brightness(const std::filesystem::path& exr) {
  const absl::StatusOr<client::Image> image = client::read_exr(exr.string());
  EXPECT_TRUE(image.ok()) << image.status();
  if (!image.ok()) return {};
  const std::vector<float>&red = image->find("R")->values, &alpha = image->find("A")->values;
  std::map<float, double> parts;
  double shown = 0;
  for (std::size_t i = 0; i < red.size(); ++i) {
    if (alpha[i] == 0) continue;
    parts[red[i]] += 1;
    shown += 1;
  }
  for (auto& [brightness, part] : parts) part /= shown;
  return parts;
}

TEST_F(Phases, ThePictureShowsWhatTheyCounted) {
  FarmUnderTest farm;
  farm.add_worker(2);
  const std::filesystem::path picture = farm.directory() / "picture.exr";
  // With one sample a pixel each shows one surface, in the brightness that is its share of all rays; and the
  // film shows all directions alike.
  const support::Finished done = tessera(
      farm.on_farm(Arguments{"submit"} + job_of("1") + Arguments{"--filter", "box", "-o", picture.string()}));
  ASSERT_EQ(done.status.code, 0) << done.err;
  const std::map<float, double> parts = parts_of_brightness(picture);
  EXPECT_GT(parts.size(), 5u) << "the box has more surfaces than this";
  double sum = 0;
  for (const auto& [brightness, part] : parts) {
    // 245,760 rays and 25,600 pixels that leave no gaps err by far less than independent ones, by 4 standard
    // deviations of which this is.
    const double error = 4 * std::sqrt(brightness * (1 / 245'760.0 + 1 / 25'600.0));
    EXPECT_NEAR(brightness, part, error);
    sum += double{brightness};
  }
  EXPECT_NEAR(sum, 1, 1e-5);
}

TEST_F(Phases, TheFarmGivesTheBitsOfOneProcess) {
  FarmUnderTest farm;
  for (int i = 0; i < 3; ++i) farm.add_worker(1);
  const std::string job = farm.submit_detached(kJob);
  const v1::JobStatus end = farm.watch_until(job, [](const v1::JobStatus&) { return false; });
  EXPECT_EQ(end.state(), v1::DONE) << end.error();
  EXPECT_EQ(end.units_total(), kPhaseUnits + 400);
  EXPECT_EQ(farm.fetch_hash(job), expected_hash(kJob));
}

// Both deaths are ordered by what is done, and the verdict is the same whenever they happen: phases_kill_test
// (soak) kills at random.
TEST_F(Phases, AWorkerAndTheCoordinatorMayDieWithinThem) {
  FarmUnderTest farm;
  // Both have one host: the death of a host's only worker would speak against the units.
  for (int i = 0; i < 2; ++i) farm.add_worker(1, "host");
  const std::string job = farm.submit_detached(kJob);
  farm.watch_until(job, [](const v1::JobStatus& status) { return status.units_done() >= 1; });
  farm.kill_worker(0);
  farm.restart_worker(0);
  farm.watch_until(job, [](const v1::JobStatus& status) { return status.units_done() >= kFirstPhaseUnits; });
  farm.kill_and_restart_coordinator();
  const v1::JobStatus end = farm.watch_to_the_end(job);
  EXPECT_EQ(end.state(), v1::DONE) << end.error();
  EXPECT_EQ(farm.fetch_hash(job), expected_hash(kJob));
}

TEST_F(Phases, MoreSamplesTakeThemOver) {
  FarmUnderTest farm;
  farm.add_worker(2);
  const std::string first = farm.submit_detached(kJob);
  farm.watch_until(first, [](const v1::JobStatus&) { return false; });
  const Arguments more = job_of("16");
  const std::string second = farm.submit_detached(more + Arguments{"--continue", first});
  const v1::JobStatus end = farm.watch_until(second, [](const v1::JobStatus&) { return false; });
  EXPECT_GE(end.units_adopted(), kPhaseUnits);
  EXPECT_EQ(farm.fetch_hash(second), expected_hash(more));
}

TEST_F(Phases, AWorkerThatDoesNotKnowTheAlgorithmSaysSo) {
  FarmUnderTest farm;
  use_programs_of(TESSERA_USUAL_PROGRAMS);
  farm.add_worker(1);
  use_programs_of(TESSERA_WITH_HISTOGRAM);
  const std::string job = farm.submit_detached(kJob);
  const v1::JobStatus end = farm.watch_until(job, [](const v1::JobStatus&) { return false; });
  EXPECT_EQ(end.state(), v1::FAILED);
  EXPECT_NE(end.error().find("there is no integrator 'histogram'"), std::string::npos) << end.error();
}

}  // namespace
}  // namespace tessera::integration
