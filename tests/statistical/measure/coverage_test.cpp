// Intervals of 95 % hold the truth in 95 % of all repetitions, for every kind of probe.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "command/measure/probe_jobs.h"
#include "google/protobuf/text_format.h"
#include "image/metrics.h"
#include "import/import.h"
#include "measure_text.h"
#include "support/process/temp_dir.h"

namespace tessera::test {
namespace {

/// Pixels that a cell has in the first round (measure/sampling.cpp), the fewest that intervals are of.
constexpr std::size_t kPixels = 16;
constexpr std::size_t kRepetitions = 4000;
/// The share of 4000 repetitions has a standard error of .34 %: three of them, and what is wanted, 95 +- 1 %.
constexpr double kAllowed = 0.0103;

/// A lamp over a floor with a ball on it.
const char* const kRoom = R"(
    materials { name: 'paint' diffuse { reflectance { constant { rgb { r: .7 g: .6 b: .5 } } } } }
    shapes { sphere { radius: 0.5 } material: 'paint' name: 'ball'
             world_from_object { elements: [1,0,0,0.8, 0,1,0,0, 0,0,1,0.2, 0,0,0,1] } }
    shapes { disk { radius: 4 } material: 'paint' name: 'floor'
             world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-0.5, 0,0,0,1] } }
    shapes { disk { radius: 0.3 } material: 'black' area_light { radiance { rgb { r: 20 g: 20 b: 20 } } }
             world_from_object { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,2.5, 0,0,0,1] } }
)";
const char* const kWhiteSky = "lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } }";

/// Part of the repetitions whose intervals hold the mean of all pixels, whose own error is a sixty-third.
double coverage_of(const std::string& probe, const std::string& scene, const std::string& algorithm) {
  const support::TempDir folder;
  const std::string path = (folder.path() / "scene.textproto").string();
  std::ofstream(path) << scene_with(scene);
  auto imported = client::import_scene(path, {});
  EXPECT_TRUE(imported.ok()) << imported.status();
  if (!imported.ok()) return 0;
  client::ProbeJobOptions how{.name = "coverage", .threads = 2};
  how.job.settings.set_integrator(algorithm);
  client::ProbeJobs jobs(*imported, how);
  client::ProbeJob job;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString("probes { " + probe + " }", &job.camera));
  job.camera.mutable_probes(0)->set_pixels(kPixels * kRepetitions);
  job.width = 256, job.height = kPixels * kRepetitions / 256, job.spp = 64, job.seed = 7;
  const auto picture = jobs.render(job);
  EXPECT_TRUE(picture.ok()) << picture.status();
  if (!picture.ok()) return 0;
  const auto value = [&](std::size_t i) { return picture->pixels[i][0]; };
  double truth = 0;
  for (std::size_t i = 0; i < kPixels * kRepetitions; ++i) truth += value(i) / (kPixels * kRepetitions);
  const double t = client::student_t_quantile(0.05, kPixels - 1);
  std::size_t held = 0;
  for (std::size_t repetition = 0; repetition < kRepetitions; ++repetition) {
    client::CellSums cell;
    for (std::size_t i = 0; i < kPixels; ++i) cell.add(picture->pixels[repetition * kPixels + i]);
    const auto luminance = client::ReadingChannel::kLuminance;
    held += std::abs(cell.mean(luminance) - truth) <= t * std::sqrt(cell.variance(luminance)) ? 1 : 0;
  }
  return static_cast<double>(held) / kRepetitions;
}

TEST(Coverage, OfEveryKindIsWhatIntervalsSay) {
  const std::string at = " point { x: -0.4 y: 0.1 } axis { z: 1 } ";
  const std::string floor =
      " plane { corner { x: -1 y: -1 } edge_u { x: 2 } edge_v { y: 2 } } axis { z: 1 } ";
  const std::string on_ball = " sphere { middle { x: 0.8 z: 0.2 } radius: 0.5 } offset: 0.0005 ";
  for (const std::string& probe : std::vector<std::string>{
           "kind: CONE field_degrees: 60" + at, "kind: PLANE" + at, "kind: SPHERE" + at,
           "kind: CYLINDER" + at, "kind: HALF_CYLINDER front { x: 1 }" + at, "kind: HALF_SPHERE" + at,
           "kind: PLANE" + floor, "kind: PLANE" + on_ball, "kind: EXITANCE" + on_ball,
           std::string("kind: PLANE inward: true sphere { radius: 5 }")}) {
    const double coverage = coverage_of(probe, std::string(kRoom) + kWhiteSky, "path");
    std::cout << probe << ": " << 100 * coverage << " %\n";
    EXPECT_NEAR(coverage, 0.95, kAllowed) << probe;
  }
}

TEST(Coverage, OfBidirectionalPathsIsWhatIntervalsSay) {
  const char* const probe = "kind: PLANE point { x: -0.4 y: 0.1 } axis { z: 1 }";
  EXPECT_NEAR(coverage_of(probe, std::string(kRoom) + kWhiteSky, "bdpt"), 0.95, kAllowed);
}

TEST(Coverage, OfLightTracingIsWhatIntervalsSay) {
  // In a ball that glows all its paths meet the walls. In the open, as under the sky above, hardly any do,
  // and tails are heavy.
  const std::string ball = R"(
      materials { name: 'paint' diffuse { reflectance { constant { rgb { r: .5 g: .5 b: .5 } } } } }
      shapes { sphere { radius: 2 } material: 'paint' reverse_orientation: true
               area_light { radiance { rgb { r: 1 g: 1 b: 1 } } } })";
  const double coverage = coverage_of("kind: PLANE point { x: 0.4 y: 0.1 } axis { z: 1 }", ball, "light");
  EXPECT_NEAR(coverage, 0.95, kAllowed);
}

}  // namespace
}  // namespace tessera::test
