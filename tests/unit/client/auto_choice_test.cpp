// Which integrators may be chosen, and which choices are taken over.
#include "command/jobs/auto_choice.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include "command/report/choice_text.h"
#include "import/import.h"
#include "local/checkpoint.h"
#include "local/local_farm.h"
#include "support/process/temp_dir.h"
#include "wire/algorithm.h"

namespace tessera::client {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

/// A scene in which nothing is to be seen: whatever is chosen costs no time.
ImportedScene empty_scene() {
  ImportedScene imported;
  imported.scene.mutable_film()->set_width(8);
  imported.scene.mutable_film()->set_height(8);
  imported.scene.mutable_camera()->mutable_perspective()->set_fov_degrees(60);
  return imported;
}

JobSettings asking_for_auto() {
  JobSettings request;
  request.settings.set_integrator(kAutoIntegrator);
  request.settings.set_spp(4);
  return request;
}

/// Why the candidate was left out; "not tried" where it is not among them.
std::string left_out(const ChosenJob& chosen, const std::string& integrator) {
  for (const v1::AutoChoice::Candidate& candidate : chosen.job->spec.farm().auto_choice().candidates()) {
    if (candidate.integrator() == integrator) return candidate.left_out();
  }
  return "not tried";
}

TEST(AutoChoice, IsAskedForByTheCommandLineOrTheScene) {
  v1::Scene scene;
  EXPECT_FALSE(asks_for_choice({}, scene));
  EXPECT_TRUE(asks_for_choice(asking_for_auto(), scene));
  scene.mutable_settings()->set_integrator("auto");
  EXPECT_TRUE(asks_for_choice({}, scene));
  JobSettings named;
  named.settings.set_integrator("bdpt");
  EXPECT_FALSE(asks_for_choice(named, scene));
}

TEST(AutoChoice, MediaArePathsThroughMedia) {
  ImportedScene scene = empty_scene();
  scene.scene.add_media()->set_name("air");
  const auto chosen = choose_job(asking_for_auto(), scene, "", {});
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_EQ(chosen->job->spec.content().algorithms().integrator(), "volpath");
  EXPECT_EQ(left_out(*chosen, "path"), "sees no media");
  EXPECT_EQ(left_out(*chosen, "light"), "sees no media");
  EXPECT_EQ(left_out(*chosen, "bdpt"), "");
}

TEST(AutoChoice, SettingsLeaveOutWhatDoesNotGoWithThem) {
  JobSettings request = asking_for_auto();
  request.settings.set_direct_light(v1::DIRECT_LIGHT_BSDF);
  const auto chosen = choose_job(request, empty_scene(), "", {});
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_EQ(chosen->job->spec.content().algorithms().integrator(), "path");
  for (const char* other : {"bdpt", "vcm", "light"}) EXPECT_THAT(left_out(*chosen, other), HasSubstr("bsdf"));

  request.settings.mutable_irradiance_cache()->set_view(true);
  EXPECT_THAT(choose_job(request, empty_scene(), "", {}).status().message(), HasSubstr("irradiance-cache"));
}

TEST(AutoChoice, FilmsWithBandsGetAnIntegratorOfWavelengths) {
  JobSettings request = asking_for_auto();
  request.settings.set_color(v1::COLOR_SPECTRAL);
  request.settings.set_film("spectral:4");
  const auto chosen = choose_job(request, empty_scene(), "", {});
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_TRUE(wire::find_algorithm(chosen->job->spec.content().algorithms().integrator())->wavelengths);
}

/// A room with a lamp and a ball of a material.
ImportedScene room(const std::string& lamp, const std::string& ball) {
  ImportedScene imported = empty_scene();
  v1::Scene shapes;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(
      "lights { " + lamp + " } materials { name: 'paint' diffuse {} } materials { name: 'ball' " + ball +
          " } shapes { material: 'paint' sphere { radius: 5 } }"
          " shapes { material: 'ball' sphere { radius: 1 }"
          "          world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,3, 0,0,0,1] } }",
      &shapes));
  imported.scene.MergeFrom(shapes);
  return imported;
}

TEST(AutoChoice, IsNoneThatNeverFindsSomeOfTheLight) {
  constexpr const char* kSpot =
      "name: 'lamp' spot { position { y: 2 } target { z: 3 } intensity { constant: 9 } cone_angle_degrees: "
      "40 }";
  const auto mirror = choose_job(asking_for_auto(), room(kSpot, "conductor {}"), "", {});
  ASSERT_TRUE(mirror.ok()) << mirror.status();
  EXPECT_EQ(mirror->job->spec.content().algorithms().integrator(), "vcm");
  EXPECT_EQ(mirror->job->spec.farm().auto_choice().reason(), "the others do not see all of the light");
  EXPECT_THAT(left_out(*mirror, "path"), HasSubstr("never finds the light of 'lamp'"));
  EXPECT_THAT(left_out(*mirror, "bdpt"), HasSubstr("where it is seen in a mirror"));
  EXPECT_THAT(left_out(*mirror, "light"), HasSubstr("does not see what is behind a mirror"));
  // Nothing is out of anyone's sight.
  const auto paint = choose_job(asking_for_auto(), room(kSpot, "diffuse {}"), "", {});
  ASSERT_TRUE(paint.ok()) << paint.status();
  for (const char* each : {"path", "bdpt", "vcm", "light"}) EXPECT_EQ(left_out(*paint, each), "");
}

/// The integrator that a pilot chooses for a picture of a minute where a sample takes a microsecond by
/// `cheap`, and so many by all others.
std::string chosen_where(const ImportedScene& scene, const std::string& cheap, double others,
                         std::string* told = nullptr) {
  JobSettings request = asking_for_auto();
  request.resolution = {128, 96};
  request.settings.set_spp(4096);
  const auto chosen =
      choose_job(request, scene, "", {.sample_cpu_seconds = [&](const std::string& integrator) {
                   return integrator == cheap ? 1e-6 : others * 1e-6;
                 }});
  EXPECT_TRUE(chosen.ok()) << chosen.status();
  if (!chosen.ok()) return "";
  if (told != nullptr) *told = choice_in_one_line(chosen->job->spec);
  return chosen->job->spec.content().algorithms().integrator();
}

TEST(AutoChoice, TakesTheLeastErrorForItsTime) {
  if (local_isas().empty()) GTEST_SKIP() << "TakesTheLeastErrorForItsTime: needs kernels";
  const auto box = import_scene("scenes/cornell-box/scene.pbrt");
  ASSERT_TRUE(box.ok()) << box.status();
  // Pixels share what paths find: a sample of theirs varies less than a quarter as much as any other's.
  EXPECT_EQ(chosen_where(*box, "path", 1), "path");
  for (const char* cheap : {"path", "light", "bdpt", "vcm"}) EXPECT_EQ(chosen_where(*box, cheap, 30), cheap);
}

TEST(AutoChoice, TakesNoneForItsTimeThatMissesLight) {
  if (local_isas().empty()) GTEST_SKIP() << "TakesNoneForItsTimeThatMissesLight: needs kernels";
  const auto glass = import_scene("scenes/glass-of-water/scene.textproto");
  ASSERT_TRUE(glass.ok()) << glass.status();
  std::string told;
  EXPECT_THAT(chosen_where(*glass, "path", 5, &told), AnyOf("bdpt", "vcm"));
  EXPECT_THAT(told, HasSubstr(", by a pilot of "));
  for (const char* tried : {"path: ", "bdpt: efficiency", "vcm: efficiency", "light: "})
    EXPECT_THAT(told, HasSubstr(tried));
}

TEST(AutoChoice, AJobThatWasBegunIsGoneOnWith) {
  const ImportedScene scene = empty_scene();
  JobSettings named = asking_for_auto();
  named.settings.set_integrator("bdpt");
  auto begun = prepare_job(named, scene, "");
  ASSERT_TRUE(begun.ok());
  v1::JobSpec spec = (*begun)->spec;
  spec.mutable_farm()->mutable_auto_choice()->set_reason("as it was");
  const support::TempDir folder;
  EXPECT_FALSE(begun_job(folder.path()).has_value());
  ASSERT_TRUE(keep_begun_job(folder.path(), spec).ok());
  const std::optional<v1::JobSpec> kept = begun_job(folder.path());
  ASSERT_TRUE(kept.has_value());

  const auto again = choose_job(asking_for_auto(), scene, "", {.begun = kept});
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->job->spec.SerializeAsString(), spec.SerializeAsString());
  JobSettings more = asking_for_auto();
  more.settings.set_spp(8);
  const auto other = choose_job(more, scene, "", {.begun = kept});
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_NE(other->job->spec.farm().auto_choice().reason(), "as it was");
}

TEST(AutoChoice, AContinuedJobKeepsItsIntegrator) {
  JobSettings named;
  named.settings.set_integrator("photon");
  const ImportedScene scene = empty_scene();
  const auto continued = prepare_job(named, scene, "");
  ASSERT_TRUE(continued.ok());
  const auto chosen = choose_job(asking_for_auto(), scene, "", {.continued = (*continued)->spec});
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_EQ(chosen->job->spec.content().algorithms().integrator(), "photon");
  EXPECT_EQ(choice_text(chosen->job->spec), "integrator photon: the job that is continued has it");
}

TEST(AutoChoice, IsToldInOneLine) {
  v1::JobSpec spec;
  EXPECT_EQ(choice_in_one_line(spec), "");
  spec.mutable_content()->mutable_algorithms()->set_integrator("bdpt");
  v1::AutoChoice& choice = *spec.mutable_farm()->mutable_auto_choice();
  choice.set_reason("2 times the efficiency of path");
  choice.set_pilot_seconds(0.25);
  v1::AutoChoice::Candidate& best = *choice.add_candidates();
  best.set_integrator("bdpt"), best.set_images(16), best.set_efficiency(800), best.set_cpu_seconds(2);
  best.set_variance(5e-4), best.set_bias2(1.25e-4);
  v1::AutoChoice::Candidate& out = *choice.add_candidates();
  out.set_integrator("light"), out.set_left_out("cannot begin at a portal");
  EXPECT_EQ(
      choice_in_one_line(spec),
      "integrator bdpt, by a pilot of 0.25 CPU s: 2 times the efficiency of path; bdpt: efficiency 800 (2 "
      "CPU s, variance 0.0005, bias^2 0.00013); light: cannot begin at a portal");
}

}  // namespace
}  // namespace tessera::client
